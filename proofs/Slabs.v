(** The tracer's box test leaves out no box that a ray meets: robust tests of crates/tracer/src/rays/slabs.rs, whose
    names these are. In f32 with subnormal numbers; what overflows is not considered here. *)
Require Import List Reals Lra Lia Psatz.
From Flocq Require Import Raux.
Require Import Trisect.Float.
Open Scope R_scope.

(** The constants of the code. *)
Definition FLATTEST_ROBUST := / 2 ^ 22.
Definition MARGIN := 16 * / 2 ^ 24.
Definition UNDERFLOW := 4 * / 2 ^ 126.

Section Slabs.
Variable rnd : R -> R.
Hypothesis arithmetic : rounding rnd u32 eta32.
Hypothesis fine : forall x, Rabs (rnd x - x) <= u32 * Rabs x + u32 * eta32.
Variable fuse : bool.
Definition mul_sub a b c := if fuse then rnd (a * b - c) else rnd (rnd (a * b) - c).

(** Origin and direction, axis by axis; the largest coordinate of the origin, of boxes and of the direction. *)
Variables o d : nat -> R.
Variables from reach fastest : R.
Hypothesis origin_within : forall k, Rabs (o k) <= from.
Hypothesis direction_within : forall k, (k < 3)%nat -> Rabs (d k) <= fastest.
Hypothesis fastest_is : exists k, (k < 3)%nat /\ Rabs (d k) = fastest.
(** Each coordinate of the direction with its sign, which that of zero may be any. *)
Variable sign : nat -> R.
Hypothesis signed : forall k, (sign k = 1 \/ sign k = -1) /\ sign k * Rabs (d k) = d k.

Definition least := rnd (fastest * FLATTEST_ROBUST).
Definition speed k := Rmax (Rabs (d k)) least.
Definition inverse k := rnd (1 / (sign k * speed k)).
Definition away := from + reach.
Definition margin k := rnd (rnd (Rabs (inverse k) * rnd (rnd away * MARGIN)) + UNDERFLOW).
Definition near k := rnd (rnd (o k * inverse k) + margin k).
Definition far k := rnd (rnd (o k * inverse k) - margin k).
(** Where the ray enters by a plane, and where it leaves by one. *)
Definition enters k v := mul_sub v (inverse k) (near k).
Definition leaves k v := mul_sub v (inverse k) (far k).

(** Something is not subnormal, and inverses are neither infinite nor subnormal. *)
Hypothesis away_normal : eta32 <= away.
Hypothesis speed_normal : forall k, eta32 <= speed k <= 2 ^ 126.
Hypothesis reach_pos : 0 <= reach.

Let u := / 2 ^ 24.
Let e := / 2 ^ 150.

Lemma off x : Rabs (rnd x - x) <= u * Rabs x + e.
Proof. pose proof (fine x) as F. unfold u32, eta32 in F. unfold u, e. lra. Qed.

Lemma from_pos : 0 <= from. Proof. pose proof (origin_within 0). pose proof (Rabs_pos (o 0%nat)). lra. Qed.

Section Axis.
Variable k : nat.
Hypothesis axis : (k < 3)%nat.
Let r := inverse k.
Let rho := Rabs r.
Let A := away * rho.
Let m := margin k.

Lemma speed_pos : 0 < speed k. Proof. pose proof (speed_normal k). unfold eta32 in *. lra. Qed.

(** [rho] is the inverse of the speed, rounded, and has the sign of the direction. *)
Lemma inverse_is : sign k * r = rho /\ 1 - u <= rho * speed k <= 1 + u.
Proof.
  destruct (signed k) as [Sg _]. pose proof speed_pos as P. pose proof (speed_normal k) as [_ L].
  assert (Hs : sign k * sign k = 1) by (destruct Sg as [-> | ->]; ring).
  set (x := 1 / (sign k * speed k)). assert (X : sign k * x * speed k = 1).
  { unfold x. field. split; [lra|]. destruct Sg as [-> | ->]; lra. }
  assert (Ax : Rabs x * speed k = 1).
  { rewrite <- (Rabs_right (speed k)) at 1 by lra. rewrite <- Rabs_mult.
    replace (x * speed k) with (sign k * (sign k * x * speed k)) by (rewrite <- !Rmult_assoc, Hs; ring).
    rewrite X. destruct Sg as [-> | ->]; unfold Rabs; destruct (Rcase_abs _); lra. }
  assert (N : eta32 <= Rabs x).
  { apply Rmult_le_reg_r with (speed k); [exact P|]. rewrite Ax. apply Rle_trans with (eta32 * 2 ^ 126).
    - apply Rmult_le_compat_l; [unfold eta32|]; lra.
    - unfold eta32. lra. }
  pose proof (rounds_normal _ _ _ arithmetic x N) as E. fold (inverse k) in E. change (rnd x) with r in E.
  assert (F : Rabs (sign k * r * speed k - 1) <= u).
  { rewrite <- X. replace (sign k * r * speed k - sign k * x * speed k) with (sign k * ((r - x) * speed k)) by ring.
    rewrite !Rabs_mult. replace (Rabs (sign k)) with 1 by (destruct Sg as [-> | ->]; unfold Rabs; destruct (Rcase_abs _); lra).
    rewrite (Rabs_right (speed k)) by lra. rewrite Rmult_1_l.
    replace u with (u32 * Rabs x * speed k) by (rewrite Rmult_assoc, Ax; unfold u, u32; ring).
    apply Rmult_le_compat_r; lra. }
  apply Rabs_le_inv in F. unfold u in *.
  assert (G : 0 < sign k * r).
  { apply Rmult_lt_reg_r with (speed k); [exact P|]. lra. }
  assert (H : sign k * r = rho).
  { unfold rho. rewrite <- (Rabs_right (sign k * r)) by lra. rewrite Rabs_mult.
    destruct Sg as [-> | ->]; unfold Rabs at 1; destruct (Rcase_abs _); lra. }
  split; [exact H|]. rewrite <- H. lra.
Qed.

Lemma rho_pos : 0 < rho.
Proof.
  destruct inverse_is as [_ [H _]]. pose proof speed_pos. unfold u in H.
  apply Rmult_lt_reg_r with (speed k); lra.
Qed.
Lemma A_pos : 0 < A.
Proof. pose proof rho_pos. unfold A. apply Rmult_lt_0_compat; [unfold eta32 in *|]; lra. Qed.

Lemma margin_is : 21 / 2 * (u * A) + / 2 ^ 125 <= m <= 18 * (u * A) + / 2 ^ 123.
Proof.
  pose proof rho_pos as P. unfold m, margin. fold r rho.
  pose proof (rounds_normal _ _ _ arithmetic away) as W. rewrite (Rabs_right away) in W by (unfold eta32 in *; lra).
  specialize (W away_normal). apply Rabs_le_inv in W. unfold u32 in W. set (w := rnd away) in *.
  pose proof (off (w * MARGIN)) as B. unfold MARGIN, eta32, u, e in *. rewrite (Rabs_right (w * _)) in B by lra.
  apply Rabs_le_inv in B. set (b := rnd (w * (16 * / 2 ^ 24))) in *.
  assert (B' : (149 / 10) * / 2 ^ 24 * away <= b <= (171 / 10) * / 2 ^ 24 * away) by lra.
  assert (C : rho * ((149 / 10) * / 2 ^ 24 * away) <= rho * b <= rho * ((171 / 10) * / 2 ^ 24 * away)).
  { split; apply Rmult_le_compat_l; lra. }
  pose proof A_pos as A0. replace (rho * ((149 / 10) * / 2 ^ 24 * away)) with ((149 / 10) * / 2 ^ 24 * A) in C by (unfold A; ring).
  replace (rho * ((171 / 10) * / 2 ^ 24 * away)) with ((171 / 10) * / 2 ^ 24 * A) in C by (unfold A; ring).
  pose proof (off (rho * b)) as D. rewrite (Rabs_right (rho * b)) in D by lra. apply Rabs_le_inv in D. unfold u, e in D.
  set (p := rnd (rho * b)) in *. unfold UNDERFLOW.
  pose proof (off (p + 4 * / 2 ^ 126)) as E. rewrite (Rabs_right (p + 4 * / 2 ^ 126)) in E by lra. apply Rabs_le_inv in E. unfold u, e in E.
  lra.
Qed.

(** What rounding takes of the distance to a plane. *)
Lemma distance v s : Rabs v <= reach -> s = 1 \/ s = -1 ->
  Rabs (mul_sub v r (rnd (rnd (o k * r) + s * m)) - ((v - o k) * r - s * m)) <= 4 * (u * A) + / 2 ^ 147 + / 2 ^ 20 * m.
Proof.
  intros Hv Hs. pose proof rho_pos as P. pose proof margin_is as [M _]. pose proof A_pos as A0.
  assert (Sum : Rabs (v * r) + Rabs (o k * r) <= A).
  { rewrite !Rabs_mult. fold rho. unfold A, away. pose proof (origin_within k).
    assert (Rabs v * rho <= reach * rho) by (apply Rmult_le_compat_r; lra).
    assert (Rabs (o k) * rho <= from * rho) by (apply Rmult_le_compat_r; lra). lra. }
  pose proof (off (o k * r)) as E1. set (q := o k * r) in *. pose proof (Rabs_pos q).
  set (q' := rnd q) in *. assert (Q : Rabs q' <= Rabs q + (u * Rabs q + e)).
  { replace q' with (q + (q' - q)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  pose proof (off (q' + s * m)) as E2. set (n := rnd (q' + s * m)) in *.
  assert (Hm : Rabs (s * m) = m).
  { unfold u in *. rewrite Rabs_mult, (Rabs_right m) by lra. destruct Hs as [-> | ->]; unfold Rabs; destruct (Rcase_abs _); lra. }
  assert (N0 : Rabs (q' + s * m) <= Rabs q' + m) by (eapply Rle_trans; [apply Rabs_triang|]; lra).
  assert (N : Rabs n <= Rabs (q' + s * m) + (u * Rabs (q' + s * m) + e)).
  { replace n with ((q' + s * m) + (n - (q' + s * m))) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  set (w := v * r) in *. pose proof (Rabs_pos w).
  replace ((v - o k) * r - s * m) with (w - q - s * m) by (unfold w, q; ring).
  unfold mul_sub. fold w. unfold u, e in *. destruct fuse.
  - pose proof (off (w - n)) as E4. unfold u, e in *.
    assert (L : Rabs (w - n) <= Rabs w + Rabs n) by (unfold Rminus; eapply Rle_trans; [apply Rabs_triang|]; rewrite Rabs_Ropp; lra).
    replace (rnd (w - n) - (w - q - s * m)) with ((rnd (w - n) - (w - n)) + - ((n - (q' + s * m)) + (q' - q))) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp.
    eapply Rle_trans; [apply Rplus_le_compat_l; apply Rabs_triang|]. lra.
  - pose proof (off w) as E3. set (w' := rnd w) in *. unfold u, e in *.
    assert (W : Rabs w' <= Rabs w + (/ 2 ^ 24 * Rabs w + / 2 ^ 150)).
    { replace w' with (w + (w' - w)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
    pose proof (off (w' - n)) as E4. unfold u, e in *.
    assert (L : Rabs (w' - n) <= Rabs w' + Rabs n) by (unfold Rminus; eapply Rle_trans; [apply Rabs_triang|]; rewrite Rabs_Ropp; lra).
    replace (rnd (w' - n) - (w - q - s * m)) with ((rnd (w' - n) - (w' - n)) + ((w' - w) + - ((n - (q' + s * m)) + (q' - q)))) by ring.
    eapply Rle_trans; [apply Rabs_triang|].
    eapply Rle_trans; [apply Rplus_le_compat_l; apply Rabs_triang|]. rewrite Rabs_Ropp.
    eapply Rle_trans; [apply Rplus_le_compat_l, Rplus_le_compat_l; apply Rabs_triang|]. lra.
Qed.

(** The place [t] of a point that is within [reach] along all axes. *)
Variable t : R.
Hypothesis within : forall i, (i < 3)%nat -> Rabs (o i + t * d i) <= reach.

Lemma t_away : Rabs t * fastest <= away /\ Rabs t * Rabs (d k) <= away.
Proof.
  assert (H : forall i, (i < 3)%nat -> Rabs t * Rabs (d i) <= away).
  { intros i I. rewrite <- Rabs_mult. replace (t * d i) with ((o i + t * d i) + - o i) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. pose proof (within i I). pose proof (origin_within i). unfold away. lra. }
  split; [|apply H; exact axis]. destruct fastest_is as (i & I & <-). apply H. exact I.
Qed.

(** What the direction that is used moves the place of the point by. *)
Lemma moved : Rabs (t * d k * r - t) <= 6 * (u * A).
Proof.
  destruct inverse_is as [Hr H]. destruct (signed k) as [Sg Hd]. destruct t_away as [T F]. pose proof rho_pos as P. pose proof A_pos.
  pose proof speed_pos as Sp. pose proof (Rabs_pos t). pose proof (Rabs_pos (d k)).
  assert (E : t * d k * r = t * (Rabs (d k) * rho)).
  { rewrite <- Hr. rewrite <- Hd at 1. ring. }
  rewrite E. replace (t * (Rabs (d k) * rho) - t) with (t * (Rabs (d k) * rho - 1)) by ring. rewrite Rabs_mult.
  unfold u in *. destruct (Rle_lt_dec least (Rabs (d k))) as [L|L].
  - assert (S : speed k = Rabs (d k)) by (unfold speed; apply Rmax_left; exact L). rewrite S in *.
    assert (Rabs (Rabs (d k) * rho - 1) <= / 2 ^ 24) by (apply Rabs_le; lra).
    assert (Rabs t * Rabs (d k) * rho <= A) by (apply Rmult_le_compat_r; lra).
    assert (Rabs t * (1 - / 2 ^ 24) <= Rabs t * (rho * Rabs (d k))) by (apply Rmult_le_compat_l; lra).
    assert (Rabs t * Rabs (Rabs (d k) * rho - 1) <= Rabs t * / 2 ^ 24) by (apply Rmult_le_compat_l; lra).
    lra.
  - assert (S : speed k = least) by (unfold speed; apply Rmax_right; lra).
    pose proof (speed_normal k) as [Nl _].
    assert (G : Rabs (d k) * rho <= speed k * rho) by (apply Rmult_le_compat_r; lra).
    assert (0 <= Rabs (d k) * rho) by (apply Rmult_le_pos; lra).
    assert (Rabs (Rabs (d k) * rho - 1) <= 1) by (apply Rabs_le; lra).
    assert (X : Rabs t * Rabs (Rabs (d k) * rho - 1) <= Rabs t * 1) by (apply Rmult_le_compat_l; lra).
    assert (Lf : least <= (1 + / 2 ^ 20) * / 2 ^ 22 * fastest).
    { rewrite S in Nl. unfold least in *. unfold FLATTEST_ROBUST in *. pose proof (off (fastest * / 2 ^ 22)) as O.
      assert (0 <= fastest) by (destruct fastest_is as (i & I & <-); apply Rabs_pos).
      rewrite (Rabs_right (fastest * _)) in O by lra. apply Rabs_le_inv in O. unfold u, e, eta32 in *. lra. }
    assert (Y : Rabs t * least <= Rabs t * ((1 + / 2 ^ 20) * / 2 ^ 22 * fastest)) by (apply Rmult_le_compat_l; lra).
    assert (Z : Rabs t * least * rho <= ((1 + / 2 ^ 20) * / 2 ^ 22 * away) * rho) by (apply Rmult_le_compat_r; lra).
    replace (((1 + / 2 ^ 20) * / 2 ^ 22 * away) * rho) with ((1 + / 2 ^ 20) * / 2 ^ 22 * A) in Z by (unfold A; ring).
    rewrite S in *.
    assert (Rabs t * (1 - / 2 ^ 24) <= Rabs t * (rho * least)) by (apply Rmult_le_compat_l; lra). lra.
Qed.

Lemma enters_before v : Rabs v <= reach -> sign k * (v - (o k + t * d k)) <= 0 -> enters k v <= t.
Proof.
  intros V H. pose proof (distance v 1 V (or_introl eq_refl)) as D. rewrite Rmult_1_l in D.
  change (mul_sub v r (rnd (rnd (o k * r) + m))) with (enters k v) in D. apply Rabs_le_inv in D. pose proof moved as M. apply Rabs_le_inv in M. pose proof margin_is. pose proof A_pos.
  destruct inverse_is as [Hr _]. destruct (signed k) as [Sg _]. pose proof rho_pos.
  assert (K : (v - (o k + t * d k)) * r <= 0).
  { replace ((v - (o k + t * d k)) * r) with ((sign k * (v - (o k + t * d k))) * (sign k * r))
      by (destruct Sg as [-> | ->]; ring).
    rewrite Hr. assert (0 <= - (sign k * (v - (o k + t * d k))) * rho) by (apply Rmult_le_pos; lra). lra. }
  replace ((v - o k) * r - m) with ((v - (o k + t * d k)) * r + t * d k * r - m) in D by ring.
  unfold u in *. lra.
Qed.

Lemma leaves_after v : Rabs v <= reach -> 0 <= sign k * (v - (o k + t * d k)) -> t <= leaves k v.
Proof.
  intros V H. pose proof (distance v (-1) V (or_intror eq_refl)) as D.
  replace (rnd (o k * r) + -1 * m) with (rnd (o k * r) - m) in D by ring.
  change (mul_sub v r (rnd (rnd (o k * r) - m))) with (leaves k v) in D. apply Rabs_le_inv in D. pose proof moved as M. apply Rabs_le_inv in M. pose proof margin_is. pose proof A_pos.
  destruct inverse_is as [Hr _]. destruct (signed k) as [Sg _]. pose proof rho_pos.
  assert (K : 0 <= (v - (o k + t * d k)) * r).
  { replace ((v - (o k + t * d k)) * r) with ((sign k * (v - (o k + t * d k))) * (sign k * r))
      by (destruct Sg as [-> | ->]; ring).
    rewrite Hr. apply Rmult_le_pos; lra. }
  replace ((v - o k) * r - -1 * m) with ((v - (o k + t * d k)) * r + t * d k * r + m) in D by ring.
  unfold u in *. lra.
Qed.
End Axis.

(** A box, by its nearer and its farther planes along each axis. *)
Variables nearer farther : nat -> R.
Hypothesis planes_within : forall k, (k < 3)%nat -> Rabs (nearer k) <= reach /\ Rabs (farther k) <= reach.
Definition enters_box tmin := Rmax (Rmax (enters 0 (nearer 0%nat)) (enters 1 (nearer 1%nat))) (Rmax (enters 2 (nearer 2%nat)) tmin).
Definition leaves_box tmax := Rmin (Rmin (leaves 0 (farther 0%nat)) (leaves 1 (farther 1%nat))) (Rmin (leaves 2 (farther 2%nat)) tmax).

(** A box that holds a point of the ray within its interval is met. *)
Theorem hit_is_not_discarded t tmin tmax : tmin <= t <= tmax ->
  (forall k, (k < 3)%nat -> sign k * nearer k <= sign k * (o k + t * d k) <= sign k * farther k) ->
  enters_box tmin <= leaves_box tmax.
Proof.
  intros T B.
  assert (W : forall i, (i < 3)%nat -> Rabs (o i + t * d i) <= reach).
  { intros i I. destruct (planes_within i I) as [X Y]. pose proof (B i I) as Z. destruct (signed i) as [S _].
    apply Rabs_le_inv in X. apply Rabs_le_inv in Y. apply Rabs_le. destruct S as [E|E]; rewrite E in Z; lra. }
  assert (E : forall k, (k < 3)%nat -> enters k (nearer k) <= t).
  { intros k K. apply enters_before; try assumption; [apply planes_within; exact K|]. pose proof (B k K). lra. }
  assert (L : forall k, (k < 3)%nat -> t <= leaves k (farther k)).
  { intros k K. apply leaves_after; try assumption; [apply planes_within; exact K|]. pose proof (B k K). lra. }
  apply Rle_trans with t.
  - unfold enters_box. repeat apply Rmax_lub; try apply E; try lia. lra.
  - unfold leaves_box. repeat apply Rmin_glb; try apply L; try lia. lra.
Qed.
End Slabs.
