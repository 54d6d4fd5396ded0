#!/usr/bin/env bash
# Tries the viewer's window on a virtual display: goes through its views and methods by keys, turns the
# camera with the mouse, and takes a screenshot of each. Fails where a window stays blank, or where what is
# done changes nothing.
#
#     crates/viewer/try-viewer.sh VIEWER FOLDER
#
# VIEWER is the built program, FOLDER where the screenshots go. It needs Xvfb, xdotool, xwd and netpbm,
# on Debian: apt-get install --no-install-recommends xvfb xdotool x11-apps netpbm. Without them it says so
# and ends with 3.
set -euo pipefail

viewer=$(realpath "${1:?the built viewer}")
folder=${2:?a folder for the screenshots}
mkdir -p "$folder"
folder=$(realpath "$folder")
cd "$(dirname "$0")/../.."

missing=()
for tool in Xvfb xdotool xwd xwdtopnm pnmtopng ppmhist; do
    command -v "$tool" >/dev/null || missing+=("$tool")
done
if ((${#missing[@]})); then
    echo "not tried: ${missing[*]} missing; on Debian: apt-get install --no-install-recommends xvfb xdotool x11-apps netpbm" >&2
    exit 3
fi

fail() {
    echo "$*" >&2
    exit 1
}

# The server takes the first display that is free, and says which.
said=$(mktemp)
Xvfb -displayfd 3 -screen 0 1280x960x24 -nolisten tcp >/dev/null 2>&1 3>"$said" &
server=$!
trap 'rm -f "$said"; kill ${program:-} "$server" 2>/dev/null || true; wait 2>/dev/null || true' EXIT
for _ in $(seq 100); do
    [[ -s $said ]] && break
    kill -0 "$server" 2>/dev/null || fail "Xvfb does not start"
    sleep 0.1
done
display=$(<"$said")
export DISPLAY=:$display

"$viewer" data/scenes/mirror.toml --width 640 --height 480 &
program=$!
window=
for _ in $(seq 100); do
    window=$(xdotool search --pid "$program" --name "mirror.toml" 2>/dev/null | tail -1 || true)
    [[ -n $window ]] && break
    kill -0 "$program" 2>/dev/null || fail "the viewer has ended"
    sleep 0.1
done
[[ -n $window ]] || fail "no window after ten seconds"
xdotool windowfocus "$window" || true

title() { xdotool getwindowname "$window"; }

# Waits until the title says something: a minute, as machines may be busy.
await() {
    for _ in $(seq 600); do
        [[ $(title) == *"$1"* ]] && return
        sleep 0.1
    done
    fail "the title is \`$(title)\`, without \`$1\`"
}

# Takes a screenshot, which must not be blank, nor be the one before.
last=
shoot() {
    local picture=$folder/$1.png
    xwd -silent -id "$window" | xwdtopnm -quiet | pnmtopng -quiet >"$picture"
    local colors
    colors=$(pngtopnm "$picture" | ppmhist -noheader | wc -l)
    ((colors > 50)) || fail "$picture: blank, $colors colours"
    [[ -z $last ]] || ! cmp --silent "$picture" "$last" || fail "$picture: nothing has changed"
    last=$picture
    echo "$1: $(title), $colors colours"
}

press() { xdotool key "$@"; }

await "picture by moller-trumbore"
await " 64 samples"
shoot picture
press h
sleep 0.5
shoot help
press h
press 3
await "triangles by"
sleep 1
shoot triangles
press 4
await "nodes by"
sleep 1
shoot nodes
press 5
await "error by moller-trumbore"
sleep 1
shoot error
press bracketright
sleep 0.5
[[ $(title) == *"error by "* && $(title) != *"by moller-trumbore ("* ]] || fail "still \`$(title)\`"
sleep 1
shoot error-of-the-next-method
press bracketleft
await "by moller-trumbore ("
press 2
await " 30 paths"
shoot paths
press 1
xdotool mousemove --window "$window" 300 240 mousedown 1
for x in 320 340 360 380; do
    xdotool mousemove --window "$window" "$x" 250
    sleep 0.1
done
xdotool mouseup 1
await " 64 samples"
shoot turned
xdotool click 4
xdotool click 4
sleep 0.3
await " 64 samples"
shoot nearer
xdotool keydown d
sleep 0.5
xdotool keyup d
await " 64 samples"
shoot walked
press Escape
for _ in $(seq 50); do
    kill -0 "$program" 2>/dev/null || { wait "$program" && exit 0 || fail "it ended with $?"; }
    sleep 0.1
done
fail "Escape does not close it"
