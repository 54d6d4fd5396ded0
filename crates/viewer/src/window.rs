//! The window: hands what keys and the mouse do to the viewer, and shows its frames.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Result, anyhow};
use glam::{Vec2, Vec3};
use minifb::{InputCallback, Key, MouseButton, MouseMode, ScaleMode, Window, WindowOptions};
use trisect_viewer::{Action, View, Viewer};

/// How often a second input is looked at, at most.
const RATE: usize = 60;

/// Shares of the distance to the middle that are walked in a second.
const SPEED: f32 = 0.8;

/// Shows a viewer until its window is closed.
pub(crate) fn show(viewer: &mut Viewer) -> Result<()> {
    let mut frame = viewer.frame();
    let [width, height] = frame.size.map(|side| side as usize);
    let options = WindowOptions {
        resize: true,
        scale_mode: ScaleMode::UpperLeft,
        ..WindowOptions::default()
    };
    let mut window = Window::new(&viewer.status(), width, height, options).map_err(|error| {
        anyhow!(
            "no window can be opened ({error}); name a display with DISPLAY, or write a picture with \
             --screenshot"
        )
    })?;
    window.set_target_fps(RATE);
    let mut hand = Hand::new(frame.size);
    window.set_input_callback(Box::new(Pressed(Rc::clone(&hand.pressed))));
    let mut actions = Vec::new();
    loop {
        let has_acted = !actions.is_empty();
        actions.drain(..).for_each(|action| viewer.act(action));
        // Computed aside, so that a hand never waits for more than what it has asked to see.
        let (stop, is_changed) = (AtomicBool::new(false), viewer.is_changed());
        let has_advanced = std::thread::scope(|scope| {
            let pass = scope.spawn(|| viewer.advance(&stop));
            while !pass.is_finished() {
                window.update();
                hand.take(&window, &mut actions);
                if !window.is_open() || hand.closes || !(is_changed || actions.is_empty()) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
            pass.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        if has_acted || has_advanced {
            frame = viewer.frame();
            window.set_title(&viewer.status());
        }
        let [width, height] = frame.size.map(|side| side as usize);
        window.update_with_buffer(&frame.pixels, width, height)?;
        hand.take(&window, &mut actions);
        if !window.is_open() || hand.closes {
            return Ok(());
        }
    }
}

/// Keys in the order in which they were pressed: of one that is up again before it is looked at, the window
/// would know nothing.
struct Pressed(Rc<RefCell<Vec<Key>>>);

impl InputCallback for Pressed {
    fn add_char(&mut self, _: u32) {}

    fn set_key_state(&mut self, key: Key, is_down: bool) {
        if is_down {
            self.0.borrow_mut().push(key);
        }
    }
}

/// What a hand did last.
struct Hand {
    pressed: Rc<RefCell<Vec<Key>>>,
    /// Of the window.
    size: [u32; 2],
    /// Where the mouse was, while it drags.
    dragged_from: Option<Vec2>,
    looked: Instant,
    /// It has asked to close the window.
    closes: bool,
}

impl Hand {
    fn new(size: [u32; 2]) -> Self {
        Self {
            pressed: Rc::default(),
            size,
            dragged_from: None,
            looked: Instant::now(),
            closes: false,
        }
    }

    /// Adds what it has done since the last time.
    fn take(&mut self, window: &Window, actions: &mut Vec<Action>) {
        let (width, height) = window.get_size();
        let size = [width, height].map(|side| u32::try_from(side).unwrap_or(0));
        if size != self.size {
            self.size = size;
            actions.push(Action::Resize(size));
        }
        self.keys(actions);
        self.walk(window, actions);
        self.mouse(window, height as f32, actions);
    }

    fn keys(&mut self, actions: &mut Vec<Action>) {
        for key in self.pressed.take() {
            actions.push(match key {
                Key::Key1 => Action::View(View::Picture),
                Key::Key2 => Action::View(View::Paths),
                Key::Key3 => Action::View(View::Triangles),
                Key::Key4 => Action::View(View::Nodes),
                Key::Key5 => Action::View(View::Error),
                Key::LeftBracket | Key::PageUp => Action::Method(-1),
                Key::RightBracket | Key::PageDown => Action::Method(1),
                Key::C => Action::NextCamera,
                Key::R => Action::Reset,
                Key::H | Key::F1 => Action::Help,
                Key::Escape => {
                    self.closes = true;
                    return;
                }
                _ => continue,
            });
        }
    }

    /// Keys that are held down.
    fn walk(&mut self, window: &Window, actions: &mut Vec<Action>) {
        let now = Instant::now();
        let time = now.duration_since(std::mem::replace(&mut self.looked, now)).as_secs_f32();
        let axis = |more: Key, less: Key| {
            let down = |key| f32::from(u8::from(window.is_key_down(key)));
            down(more) - down(less)
        };
        let by = Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
        if by != Vec3::ZERO {
            actions.push(Action::Walk(by * (SPEED * time)));
        }
    }

    fn mouse(&mut self, window: &Window, height: f32, actions: &mut Vec<Action>) {
        if let Some((_, notches)) = window.get_scroll_wheel()
            && notches != 0.0
        {
            actions.push(Action::Dolly(notches.signum()));
        }
        let is_down = |button| window.get_mouse_down(button);
        let turns = is_down(MouseButton::Left);
        let pans = is_down(MouseButton::Right)
            || is_down(MouseButton::Middle)
            || turns && (window.is_key_down(Key::LeftShift) || window.is_key_down(Key::RightShift));
        let at = window.get_mouse_pos(MouseMode::Pass).map(|(x, y)| Vec2::new(x, y));
        let Some(at) = at.filter(|_| turns || pans) else {
            self.dragged_from = None;
            return;
        };
        let by = (at - self.dragged_from.replace(at).unwrap_or(at)) / height.max(1.0);
        if by != Vec2::ZERO {
            actions.push(if pans { Action::Pan(by) } else { Action::Turn(by) });
        }
    }
}
