(** Between which numbers [t] of a hit lies, as the filter computes them for who orders hits ([filter::screened]); and
    that nothing overflows where the bound says something. *)
Require Import List Reals Lra Lia Psatz.
Import ListNotations.
From Flocq Require Import Raux.
Require Import Trisect.Bound Trisect.Float Trisect.Methods Trisect.Norms Trisect.Filter.
Open Scope R_scope.

(** The constants of the code. *)
Definition NO_BOUND := 2 ^ 30.
Definition UNDERFLOW := / 2 ^ 124.

Section Hit.
Variable rnd : R -> R.
Variables u eta : R.
Hypothesis arithmetic : rounding rnd u eta.
Hypothesis precise : 0 < u <= / 2 ^ 24.
Hypothesis wide : 0 <= eta <= u * / 2 ^ 102.
Variables v f : nat -> R.
Hypothesis reads : forall i, Rabs (f i - v i) <= eta.
Variable fuse : bool.
Hypothesis is_fast : SLOWEST <= size rnd f.

Notation "'use' l" := (l rnd u eta arithmetic precise wide v f reads fuse is_fast) (at level 10, l at level 9).
Notation computed := (Filter.computed rnd f fuse).
Notation mul_add := (Filter.mul_add rnd fuse).
Notation bound := (Filter.bound rnd u f fuse).
Notation h := (Filter.h rnd f).
Notation distance := (Filter.distance rnd f).
Notation size := (Filter.size rnd f).
Notation unit := (Filter.unit rnd u).
Notation reach := (Filter.reach rnd f fuse).
Notation S' := (Filter.S' rnd eta f).
Notation h' := (Filter.h' rnd f).
Let rho := h + 2 * distance.
Let HH := h * h.
Let rounded := rounds _ _ _ arithmetic.
Let u_pos : 0 <= u. Proof. lra. Qed.
Let eta_pos : 0 <= eta. Proof. lra. Qed.

(** *** Losses apart: [x'] is off by [k] roundings of [p] and by [r] of underflow. *)
Definition apart x x' p k r := Rabs (x' - x) <= ((1 + u) ^ k - 1) * p + (1 + u) ^ k * r /\ Rabs x <= p /\ 0 <= r.

Lemma apart_more x x' p k r k' r' : (k <= k')%nat -> r <= r' -> apart x x' p k r -> apart x x' p k' r'.
Proof.
  intros K R' [E [P R0]]. pose proof (Rabs_pos x). split; [|split; lra].
  assert ((1 + u) ^ k <= (1 + u) ^ k') by (apply Rle_pow; [lra|exact K]). pose proof (pow_u u u_pos k).
  assert (((1 + u) ^ k - 1) * p <= ((1 + u) ^ k' - 1) * p) by (apply Rmult_le_compat_r; lra).
  assert ((1 + u) ^ k * r <= (1 + u) ^ k' * r') by (apply Rmult_le_compat; lra). lra.
Qed.
Lemma apart_rnd x x' p k r : apart x x' p k r -> apart x (rnd x') p (S k) (r + eta).
Proof.
  intros [E [P R0]]. split; [|split; lra]. pose proof (pow_u u u_pos k). cbn [pow]. set (A := (1 + u) ^ k) in *.
  assert (Rabs x' <= A * p + A * r).
  { replace x' with (x + (x' - x)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  replace (rnd x' - x) with ((rnd x' - x') + (x' - x)) by ring. eapply Rle_trans; [apply Rabs_triang|].
  pose proof (rounded x'). assert (u * Rabs x' <= u * (A * p + A * r)) by (apply Rmult_le_compat_l; lra).
  assert (0 <= u * A) by (apply Rmult_le_pos; lra). assert (0 <= u * A * eta) by (apply Rmult_le_pos; lra).
  assert (1 * eta <= A * eta) by (apply Rmult_le_compat_r; lra). lra.
Qed.
Lemma apart_add x x' p y y' q k r s : apart x x' p k r -> apart y y' q k s -> apart (x + y) (x' + y') (p + q) k (r + s).
Proof.
  intros [E [P R0]] [F [Q R1]]. split; [|split; [|lra]].
  - replace (x' + y' - (x + y)) with ((x' - x) + (y' - y)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra.
  - eapply Rle_trans; [apply Rabs_triang|]. lra.
Qed.
Lemma apart_mul x x' p y y' q k l r s : apart x x' p k r -> apart y y' q l s ->
  apart (x * y) (x' * y') (p * q) (k + l) (r * q + p * s + r * s).
Proof.
  intros [E [P R0]] [F [Q R1]]. pose proof (Rabs_pos x). pose proof (Rabs_pos y).
  pose proof (Rabs_pos (x' - x)). pose proof (Rabs_pos (y' - y)).
  pose proof (pow_u u u_pos k). pose proof (pow_u u u_pos l). split; [|split].
  - replace (x' * y' - x * y) with ((x' - x) * (y' - y) + (x * (y' - y) + (x' - x) * y)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. eapply Rle_trans; [apply Rplus_le_compat_l; apply Rabs_triang|].
    rewrite !Rabs_mult, pow_add. set (A := (1 + u) ^ k) in *. set (B := (1 + u) ^ l) in *.
    assert (Rabs (x' - x) * Rabs (y' - y) <= ((A - 1) * p + A * r) * ((B - 1) * q + B * s)) by (apply Rmult_le_compat; lra).
    assert (Rabs x * Rabs (y' - y) <= p * ((B - 1) * q + B * s)) by (apply Rmult_le_compat; lra).
    assert (Rabs (x' - x) * Rabs y <= ((A - 1) * p + A * r) * q) by (apply Rmult_le_compat; lra).
    lra.
  - rewrite Rabs_mult. apply Rmult_le_compat; lra.
  - assert (0 <= r * q) by (apply Rmult_le_pos; lra). assert (0 <= p * s) by (apply Rmult_le_pos; lra).
    assert (0 <= r * s) by (apply Rmult_le_pos; lra). lra.
Qed.
Lemma near_apart x x' p q k l : near u eta 1 x x' p q k l -> (l <= 32)%nat -> apart x x' p k ((INR l + / 8) * eta * q).
Proof.
  intros [E [P Q]] L. pose proof (Rabs_pos x). assert (Q0 : 0 <= q) by lra. replace (lost eta 1) with eta in E by (unfold lost; field).
  pose proof (pow_le eta l ltac:(lra) ltac:(lia)). pose proof (pow_u u u_pos k).
  assert (1 <= (1 + eta) ^ l) by (apply pow_R1_Rle; lra). pose proof (pos_INR l).
  assert (INR l <= INR 32) by (apply le_INR; lia). replace (INR 32) with 32 in * by (simpl; lra).
  assert (INR l * eta <= 32 * eta) by (apply Rmult_le_compat_r; lra).
  assert (((1 + eta) ^ l - 1) * q <= (INR l + / 8) * eta * q) by (apply Rmult_le_compat_r; lra).
  assert (0 <= (INR l + / 8) * eta * q) by (apply Rmult_le_pos; [apply Rmult_le_pos|]; lra).
  split; [|split; lra]. rewrite Rmult_assoc in E.
  assert ((1 + u) ^ k * (((1 + eta) ^ l - 1) * q) <= (1 + u) ^ k * ((INR l + / 8) * eta * q)) by (apply Rmult_le_compat_l; lra).
  lra.
Qed.

(** A scalar product of what is [near]: what its own five operations lose is not multiplied by anything. *)
Definition dot x1 y1 x2 y2 x3 y3 := mul_add x1 y1 (mul_add x2 y2 (rnd (x3 * y3))).
Lemma apart_dot x1 y1 x2 y2 x3 y3 x1' y1' x2' y2' x3' y3' p1 q1 p2 q2 p3 q3 k r1 r2 r3 :
  apart (x1 * y1) (x1' * y1') (p1 * q1) k r1 -> apart (x2 * y2) (x2' * y2') (p2 * q2) k r2 ->
  apart (x3 * y3) (x3' * y3') (p3 * q3) k r3 ->
  apart (x1 * y1 + (x2 * y2 + x3 * y3)) (dot x1' y1' x2' y2' x3' y3') (p1 * q1 + (p2 * q2 + p3 * q3)) (S (S (S k)))
    (r1 + r2 + r3 + 5 * eta).
Proof.
  intros A B C. unfold dot, Filter.mul_add.
  assert (Up : forall x x' p r l, apart x x' p k r -> (k <= l)%nat -> apart x x' p l r).
  { intros x x' p r l X L. exact (apart_more _ _ _ _ _ _ _ L (Rle_refl r) X). }
  pose proof (apart_rnd _ _ _ _ _ C) as C1. destruct fuse.
  - pose proof (apart_rnd _ _ _ _ _ (apart_add _ _ _ _ _ _ _ _ _ (Up _ _ _ _ (S k) B ltac:(lia)) C1)) as B1.
    pose proof (apart_rnd _ _ _ _ _ (apart_add _ _ _ _ _ _ _ _ _ (Up _ _ _ _ (S (S k)) A ltac:(lia)) B1)) as A1.
    eapply apart_more; [| |exact A1]; [lia|lra].
  - pose proof (apart_rnd _ _ _ _ _ B) as B0. pose proof (apart_rnd _ _ _ _ _ A) as A0.
    pose proof (apart_rnd _ _ _ _ _ (apart_add _ _ _ _ _ _ _ _ _ B0 C1)) as B1.
    apply (apart_more _ _ _ _ _ (S (S k)) (r1 + eta)) in A0; [|lia|lra].
    pose proof (apart_rnd _ _ _ _ _ (apart_add _ _ _ _ _ _ _ _ _ A0 B1)) as A1.
    eapply apart_more; [| |exact A1]; [lia|lra].
Qed.

Let Rho0 : SHORTEST <= rho. Proof. exact (use rho_ge). Qed.
Let H0 : SHORTEST <= h. Proof. exact (use h_ge). Qed.
Let D0 : 0 <= distance. Proof. exact (use distance_pos). Qed.

Definition n_norm := 2 * (h' + 0) * (h' + 0).
Lemma normal_sizes : forall i j k l m n o p, List.In [i; j; k; l; m; n; o; p]
  [[13; 7; 11; 8; 14; 8; 10; 7]; [14; 8; 9; 6; 12; 6; 11; 8]; [12; 6; 10; 7; 13; 7; 9; 6]]%nat ->
  forall c, 0 <= c -> magnitude v c (MulSub (Diff i j) (Diff k l) (Mul (Diff m n) (Diff o p))) <= 2 * (h' + c) ^ 2.
Proof.
  intros i j k l m n o p I c C. destruct (use is_sized) as [s0 s1 s2 b0 b1 b2 c0 c1 c2]. cbn [magnitude].
  replace (2 * (h' + c) ^ 2) with ((h' + c) * (h' + c) + (h' + c) * (h' + c)) by ring.
  assert (P : forall a, 0 <= Rabs a + c) by (intro a; pose proof (Rabs_pos a); lra).
  destruct I as [E|[E|[E|[]]]]; injection E as <- <- <- <- <- <- <- <-;
    apply Rplus_le_compat; apply Rmult_le_compat; try apply P; lra.
Qed.
End Hit.
