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
Variables fuse stored : bool.
Hypothesis is_fast : SLOWEST <= size rnd f.

Notation "'use' l" := (l rnd u eta arithmetic precise wide v f reads fuse stored is_fast) (at level 10, l at level 9).
Notation computed := (Filter.computed rnd f fuse stored).
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

(** *** [T], with its own roundings apart *)

Lemma normal_size n c : List.In n [n_x; n_y; n_z] -> 0 <= c -> magnitude v c n <= 2 * (h' + c) ^ 2.
Proof.
  intros I C. destruct (use is_sized) as [s0 s1 s2 b0 b1 b2 c0 c1 c2].
  replace (2 * (h' + c) ^ 2) with ((h' + c) * (h' + c) + (h' + c) * (h' + c)) by ring.
  assert (P : forall a, 0 <= Rabs a + c) by (intro a; pose proof (Rabs_pos a); lra).
  destruct I as [<-|[<-|[<-|[]]]]; cbn [n_x n_y n_z magnitude];
    apply Rplus_le_compat; apply Rmult_le_compat; try apply P; lra.
Qed.

Let hp0 : 0 <= h'. Proof. unfold Filter.h', SHORTEST in *. lra. Qed.
Let Sp0 : 0 <= S'. Proof. exact (use S'_pos). Qed.
Let HH0 : 0 < HH. Proof. unfold HH, SHORTEST in *. apply Rmult_lt_0_compat; lra. Qed.
Let hh0 : (h' + 0) ^ 2 <= (1 + / 2 ^ 17) * HH.
Proof. replace ((h' + 0) ^ 2) with ((1 + / 2 ^ 19) ^ 2 * HH) by (unfold Filter.h', HH; ring). apply Rmult_le_compat_r; lra. Qed.
Let hh1 : (h' + 1) ^ 2 <= (2 ^ 34 + 2) ^ 2 * HH.
Proof.
  pose proof (use h'_plus) as H. unfold SHORTEST in *. replace ((h' + 1) ^ 2) with ((h' + 1) * (h' + 1)) by ring.
  replace ((2 ^ 34 + 2) ^ 2 * HH) with (((2 ^ 34 + 2) * h) * ((2 ^ 34 + 2) * h)) by (unfold HH; ring).
  apply Rmult_le_compat; lra.
Qed.
Let reach0 : h' + 2 * S' <= (1 + / 2 ^ 18) * rho. Proof. exact (use rho'_le). Qed.
Let Sp1 : S' + 1 <= (2 ^ 34 + 2) * rho.
Proof. unfold SHORTEST in *. lra. Qed.
Let X := HH * rho.
Let X0 : 0 < X. Proof. unfold X, SHORTEST in *. apply Rmult_lt_0_compat; lra. Qed.
Let eta_small : eta <= / 2 ^ 126.
Proof. assert (u * / 2 ^ 102 <= / 2 ^ 24 * / 2 ^ 102) by (apply Rmult_le_compat_r; lra). lra. Qed.

(** A product of a coordinate of [s] and of the normal. *)
Lemma term i j n : Rabs (v i - v j) <= S' -> List.In n [n_x; n_y; n_z] ->
  apart ((v i - v j) * exact v n) (difference rnd f i j * computed n) (Rabs (v i - v j) * perm v n) 5 (/ 2 ^ 12 * u * X).
Proof.
  intros Hs I.
  assert (A : near u eta 1 (v i - v j) (difference rnd f i j) (Rabs (v i - v j)) (Rabs (v i - v j) + 1) 1 3).
  { pose proof (bounded rnd u eta u_pos eta_pos rounded v f reads 1 (Rle_refl 1) (Diff i j)) as B.
    unfold perm in B. cbn [exact float magnitude depth losses] in B. rewrite Rplus_0_r in B. exact B. }
  assert (B : near u eta 1 (exact v n) (computed n) (perm v n) (magnitude v 1 n) 4 8).
  { pose proof (use volume n) as B. eapply near_weaken; [exact u_pos|exact eta_pos|exact (Rle_refl 1)| | |exact B];
      destruct I as [<-|[<-|[<-|[]]]]; apply PeanoNat.Nat.leb_le; reflexivity. }
  apply near_apart in A; [|lia]. apply near_apart in B; [|lia].
  replace (INR 3) with 3 in A by (simpl; lra). replace (INR 8) with 8 in B by (simpl; lra).
  pose proof (apart_mul _ _ _ _ _ _ _ _ _ _ A B) as C. eapply apart_more; [| |exact C]; [lia|].
  pose proof (normal_size n 0 I (Rle_refl 0)) as P. pose proof (normal_size n 1 I Rle_0_1) as M. fold (perm v n) in P.
  assert (P0 : 0 <= perm v n) by (apply magnitude_pos; lra). assert (M0 : 0 <= magnitude v 1 n) by (apply magnitude_pos; lra).
  pose proof (Rabs_pos (v i - v j)). unfold SHORTEST in *.
  set (a := Rabs (v i - v j)) in *. set (pn := perm v n) in *. set (mn := magnitude v 1 n) in *.
  assert (T1 : (3 + / 8) * eta * (a + 1) * pn <= (3 + / 8) * (u * / 2 ^ 102) * ((2 ^ 34 + 2) * rho) * (2 * ((1 + / 2 ^ 17) * HH))).
  { repeat apply Rmult_le_compat; try lra; repeat apply Rmult_le_pos; lra. }
  assert (T2 : a * ((8 + / 8) * eta * mn) <= rho * ((8 + / 8) * (u * / 2 ^ 102) * (2 * ((2 ^ 34 + 2) ^ 2 * HH)))).
  { repeat apply Rmult_le_compat; try lra; repeat apply Rmult_le_pos; lra. }
  assert (T3 : (3 + / 8) * eta * (a + 1) * ((8 + / 8) * eta * mn)
    <= (3 + / 8) * (u * / 2 ^ 102) * ((2 ^ 34 + 2) * rho) * ((8 + / 8) * / 2 ^ 126 * (2 * ((2 ^ 34 + 2) ^ 2 * HH)))).
  { repeat apply Rmult_le_compat; try lra; repeat apply Rmult_le_pos; lra. }
  assert (0 < u * X) by (apply Rmult_lt_0_compat; lra).
  replace ((3 + / 8) * (u * / 2 ^ 102) * ((2 ^ 34 + 2) * rho) * (2 * ((1 + / 2 ^ 17) * HH)))
    with ((3 + / 8) * / 2 ^ 102 * (2 ^ 34 + 2) * 2 * (1 + / 2 ^ 17) * (u * X)) in T1 by (unfold X; ring).
  replace (rho * ((8 + / 8) * (u * / 2 ^ 102) * (2 * ((2 ^ 34 + 2) ^ 2 * HH))))
    with ((8 + / 8) * / 2 ^ 102 * 2 * (2 ^ 34 + 2) ^ 2 * (u * X)) in T2 by (unfold X; ring).
  replace ((3 + / 8) * (u * / 2 ^ 102) * ((2 ^ 34 + 2) * rho) * ((8 + / 8) * / 2 ^ 126 * (2 * ((2 ^ 34 + 2) ^ 2 * HH))))
    with ((3 + / 8) * / 2 ^ 102 * (2 ^ 34 + 2) * (8 + / 8) * / 2 ^ 126 * 2 * (2 ^ 34 + 2) ^ 2 * (u * X)) in T3 by (unfold X; ring).
  lra.
Qed.

(** [T] is off by eight roundings, by what its five own operations lose, and by next to nothing. *)
Lemma t_apart : apart (exact v T) (computed T) (perm v T) 8 (/ 2 ^ 10 * u * X + 5 * eta).
Proof.
  destruct (use is_sized) as [s0 s1 s2 b0 b1 b2 c0 c1 c2].
  pose proof (apart_dot _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _
    (term 6 0 n_x s0 ltac:(simpl; tauto)) (term 7 1 n_y s1 ltac:(simpl; tauto)) (term 8 2 n_z s2 ltac:(simpl; tauto))) as D.
  assert (E : dot (difference rnd f 6 0) (computed n_x) (difference rnd f 7 1) (computed n_y) (difference rnd f 8 2) (computed n_z)
              = computed T) by (unfold dot, Filter.mul_add, Filter.computed, form; destruct fuse, stored; reflexivity).
  rewrite E in D.
  replace (exact v T) with ((v 6%nat - v 0%nat) * exact v n_x + ((v 7%nat - v 1%nat) * exact v n_y + (v 8%nat - v 2%nat) * exact v n_z))
    by reflexivity.
  replace (perm v T) with (Rabs (v 6%nat - v 0%nat) * perm v n_x + (Rabs (v 7%nat - v 1%nat) * perm v n_y + Rabs (v 8%nat - v 2%nat) * perm v n_z))
    by (unfold perm; cbn [magnitude n_x n_y n_z exact_t]; rewrite !Rplus_0_r; reflexivity).
  assert (0 < u * X) by (apply Rmult_lt_0_compat; lra).
  eapply apart_more; [| |exact D]; [lia|lra].
Qed.

(** *** The bound from below *)

Let c := 1 - / 2 ^ 24.
Lemma below' x y : eta <= x -> x <= y -> c * x <= rnd y.
Proof. intros A B. pose proof (use below_c x y A B) as C. cbv zeta in C. exact C. Qed.

Lemma bound_of_hit_ge : (1 - / 2 ^ 20) * (3 * FACTOR * (u * X) + 8 * eta) <= Filter.bound_of_hit rnd u eta f fuse.
Proof.
  destruct (use hh_ge) as [A A']. destruct (use three_unit_ge) as [B B']. pose proof (use reach_ge) as R. cbv zeta in *.
  fold rho in R. fold c in A, B. fold HH in A, A'. unfold SHORTEST in *.
  assert (E1 : / 2 ^ 35 * (53 * u) <= reach * rnd (3 * unit)) by (apply Rmult_le_compat; lra).
  pose proof (below' (reach * rnd (3 * unit)) _ ltac:(lra) (Rle_refl _)) as F.
  assert (G : (1 - / 2 ^ 22) * rho * (c * c * (3 * (u * FACTOR))) <= reach * rnd (3 * unit)).
  { apply Rmult_le_compat; try lra. unfold c, FACTOR. lra. }
  assert (K : c * HH * (c * ((1 - / 2 ^ 22) * rho * (c * c * (3 * (u * FACTOR))))) <= rnd (h * h) * rnd (reach * rnd (3 * unit))).
  { apply Rmult_le_compat; try exact A.
    - unfold c. lra.
    - apply Rmult_le_pos; [unfold c; lra|]. apply Rmult_le_pos; unfold c, FACTOR; lra.
    - eapply Rle_trans; [|exact F]. apply Rmult_le_compat_l; [unfold c; lra|exact G]. }
  set (p := rnd (h * h) * rnd (reach * rnd (3 * unit))) in *.
  assert (U0 : 0 < u * X) by (apply Rmult_lt_0_compat; lra).
  replace (c * HH * (c * ((1 - / 2 ^ 22) * rho * (c * c * (3 * (u * FACTOR))))))
    with (c * c * c * c * (1 - / 2 ^ 22) * (3 * FACTOR) * (u * X)) in K by (unfold X; ring).
  assert (X1 : / 2 ^ 102 <= X).
  { unfold X. replace (/ 2 ^ 102) with (/ 2 ^ 68 * / 2 ^ 34) by lra. apply Rmult_le_compat; lra. }
  assert (X2 : u * / 2 ^ 102 <= u * X) by (apply Rmult_le_compat_l; lra).
  assert (K' : 50 * (u * X) <= p).
  { eapply Rle_trans; [|exact K]. apply Rmult_le_compat_r; [lra|]. unfold c, FACTOR. lra. }
  assert (P : c * p <= rnd p) by (apply below'; lra).
  assert (E8 : c * (8 * eta) <= rnd (8 * eta)) by (apply below'; lra).
  assert (Kn : (1 - / 2 ^ 20) * (3 * FACTOR) * (u * X) <= c * c * p).
  { apply Rle_trans with (c * c * (c * c * c * c * (1 - / 2 ^ 22) * (3 * FACTOR) * (u * X))).
    - replace (c * c * (c * c * c * c * (1 - / 2 ^ 22) * (3 * FACTOR) * (u * X)))
        with (c * c * c * c * c * c * (1 - / 2 ^ 22) * (3 * FACTOR) * (u * X)) by ring.
      apply Rmult_le_compat_r; [lra|]. apply Rmult_le_compat_r; unfold c, FACTOR; lra.
    - apply Rmult_le_compat_l; [unfold c; lra|exact K]. }
  unfold Filter.bound_of_hit, Filter.mul_add. fold p. destruct fuse.
  - apply Rle_trans with (c * (p + rnd (8 * eta))); [|apply below'; unfold c in *; lra]. unfold c in *. lra.
  - apply Rle_trans with (c * (c * p + c * (8 * eta))); [|apply below'; unfold c in *; lra]. unfold c in *. lra.
Qed.

(** *** Of a hit *)

Lemma d1_ge : size <= (1 + / 2 ^ 19) * d1 v.
Proof.
  assert (A : forall i, Rabs (f i) <= Rabs (v i) + eta).
  { intro i. pose proof (reads i). replace (f i) with (v i + (f i - v i)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  pose proof (A 3%nat). pose proof (A 4%nat). pose proof (A 5%nat). unfold d1, Filter.size, SLOWEST in *.
  set (x := Rabs (f 3%nat)) in *. set (y := Rabs (f 4%nat) + Rabs (f 5%nat)) in *.
  assert (L : forall z, Rabs (rnd z) <= (1 + / 2 ^ 24) * Rabs z + eta).
  { intro z. pose proof (rounded z). assert (u * Rabs z <= / 2 ^ 24 * Rabs z) by (apply Rmult_le_compat_r; [apply Rabs_pos|lra]).
    replace (rnd z) with (z + (rnd z - z)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  pose proof (L y) as Y. pose proof (L (x + rnd y)) as Z. pose proof (Rabs_pos (f 3%nat)). pose proof (Rabs_pos (f 4%nat)). pose proof (Rabs_pos (f 5%nat)).
  rewrite (Rabs_right y) in Y by (unfold y; lra). pose proof (Rle_abs (rnd (x + rnd y))).
  assert (Rabs (x + rnd y) <= x + Rabs (rnd y)).
  { eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_right x) by (unfold x; lra). lra. }
  unfold x, y in *. lra.
Qed.

Variables t beta gamma : R.
Hypothesis is_met : meets v t beta gamma.
Hypothesis is_inside : 0 <= beta /\ 0 <= gamma /\ beta + gamma <= 1.

(** The point of the hit is within [h] of [A], along each axis. *)
Lemma t_far : Rabs t * d1 v <= 3 * (S' + h').
Proof.
  destruct (use is_sized) as [s0 s1 s2 b0 b1 b2 c0 c1 c2]. destruct is_inside as (B & C & BC).
  assert (K : forall a b e d, Rabs a <= S' -> Rabs b <= h' -> Rabs e <= h' -> t * d = a + beta * b + gamma * e -> Rabs t * Rabs d <= S' + h').
  { intros a b e d Ha Hb He E. rewrite <- Rabs_mult, E.
    eapply Rle_trans; [apply Rabs_triang|]. eapply Rle_trans; [apply Rplus_le_compat_r; apply Rabs_triang|].
    rewrite !Rabs_mult, (Rabs_right beta), (Rabs_right gamma) by lra.
    assert (beta * Rabs b <= beta * h') by (apply Rmult_le_compat_l; lra).
    assert (gamma * Rabs e <= gamma * h') by (apply Rmult_le_compat_l; lra).
    assert ((beta + gamma) * h' <= 1 * h') by (apply Rmult_le_compat_r; lra). lra. }
  pose proof (is_met 0%nat ltac:(lia)) as M0. pose proof (is_met 1%nat ltac:(lia)) as M1. pose proof (is_met 2%nat ltac:(lia)) as M2.
  cbn [Nat.add] in *.
  pose proof (K _ _ _ (v 3%nat) s0 b0 c0 ltac:(lra)). pose proof (K _ _ _ (v 4%nat) s1 b1 c1 ltac:(lra)).
  pose proof (K _ _ _ (v 5%nat) s2 b2 c2 ltac:(lra)). unfold d1. lra.
Qed.

(** What the quotient of the numerators is off by, times [det]. *)
Lemma numerators : Rabs (computed T - t * computed det) <= (1 - / 2 ^ 16) * Filter.bound_of_hit rnd u eta f fuse.
Proof.
  destruct (meets_volumes v _ _ _ is_met) as (E & _). pose proof t_far as F. pose proof d1_ge as G.
  destruct t_apart as [A _]. pose proof (use volume det) as D.
  pose proof (Rabs_pos t) as T0. pose proof (use d1_pos) as D1.
  eapply near_weaken with (k' := 7%nat) (l' := 12%nat) in D;
    [|exact u_pos|exact eta_pos|exact (Rle_refl 1)|apply PeanoNat.Nat.leb_le; reflexivity|apply PeanoNat.Nat.leb_le; reflexivity].
  pose proof (use near_error _ _ _ _ _ _ D ltac:(lia) ltac:(lia)) as B.
  replace (INR 7) with 7 in B by (simpl; lra). replace (INR 12) with 12 in B by (simpl; lra).
  pose proof (det_norm v S' h' 0 (use is_sized) (Rle_refl 0)) as P. pose proof (det_norm v S' h' 1 (use is_sized) Rle_0_1) as M.
  pose proof (t_norm v S' h' 0 (use is_sized) (Rle_refl 0)) as PT. fold (perm v det) in P. fold (perm v T) in PT.
  set (pd := perm v det) in *. set (md := magnitude v 1 det) in *. set (pt := perm v T) in *.
  assert (pd0 : 0 <= pd) by (apply magnitude_pos; lra). assert (md0 : 0 <= md) by (apply magnitude_pos; lra).
  assert (pt0 : 0 <= pt) by (apply magnitude_pos; lra).
  unfold SLOWEST, SHORTEST in *. pose proof bound_of_hit_ge as L. set (b := Filter.bound_of_hit rnd u eta f fuse) in *.
  assert (U0 : 0 < u * X) by (apply Rmult_lt_0_compat; lra).
  (* T *)
  pose proof (pow_le u 8 ltac:(lra) ltac:(lia)) as P8. replace (INR 8) with 8 in P8 by (simpl; lra). pose proof (pow_u u u_pos 8).
  assert (A1 : ((1 + u) ^ 8 - 1) * pt <= 8 * (u * (1 + / 2 ^ 16)) * pt) by (apply Rmult_le_compat_r; lra).
  assert (A2 : (1 + u) ^ 8 * (/ 2 ^ 10 * u * X + 5 * eta) <= (1 + / 2 ^ 19) * (/ 2 ^ 10 * u * X + 5 * eta)) by (apply Rmult_le_compat_r; lra).
  assert (H2 : 0 <= (h' + 0) ^ 2) by apply pow2_ge_0.
  assert (A3 : (S' + 0) * (h' + 0) ^ 2 <= (S' + 0) * ((1 + / 2 ^ 17) * HH)) by (apply Rmult_le_compat_l; lra).
  (* det *)
  assert (H3 : 0 <= (h' + 1) ^ 2) by apply pow2_ge_0.
  assert (B1 : Rabs t * pd <= 2 * (3 * (S' + h')) * ((1 + / 2 ^ 17) * HH)).
  { apply Rle_trans with (Rabs t * (2 * (d1 v + 3 * 0) * (h' + 0) ^ 2)); [apply Rmult_le_compat_l; lra|].
    replace (Rabs t * (2 * (d1 v + 3 * 0) * (h' + 0) ^ 2)) with (2 * (Rabs t * d1 v) * (h' + 0) ^ 2) by ring.
    apply Rmult_le_compat; try lra. assert (0 <= Rabs t * d1 v) by (apply Rmult_le_pos; lra). lra. }
  assert (T1 : Rabs t <= (2 ^ 20 + 2) * (3 * (S' + h'))).
  { assert (Rabs t * / (2 ^ 20 + 2) <= Rabs t * d1 v) by (apply Rmult_le_compat_l; lra). lra. }
  assert (B2 : Rabs t * md <= 2 * ((3 * 2 ^ 20 + 8) * (3 * (S' + h'))) * ((2 ^ 34 + 2) ^ 2 * HH)).
  { apply Rle_trans with (Rabs t * (2 * (d1 v + 3 * 1) * (h' + 1) ^ 2)); [apply Rmult_le_compat_l; lra|].
    replace (Rabs t * (2 * (d1 v + 3 * 1) * (h' + 1) ^ 2)) with (2 * (Rabs t * d1 v + 3 * Rabs t) * (h' + 1) ^ 2) by ring.
    apply Rmult_le_compat; try lra. assert (0 <= Rabs t * d1 v) by (apply Rmult_le_pos; lra). lra. }
  assert (B3 : Rabs t * Rabs (computed det - exact v det) <= Rabs t * (7 * (u * (1 + / 2 ^ 16)) * pd + (12 + / 8) * eta * md)).
  { apply Rmult_le_compat_l; [exact T0|exact B]. }
  assert (B4 : eta * (Rabs t * md) <= u * / 2 ^ 102 * (2 * ((3 * 2 ^ 20 + 8) * (3 * (S' + h'))) * ((2 ^ 34 + 2) ^ 2 * HH))).
  { apply Rmult_le_compat; try lra. apply Rmult_le_pos; lra. }
  assert (B5 : u * (Rabs t * pd) <= u * (2 * (3 * (S' + h')) * ((1 + / 2 ^ 17) * HH))) by (apply Rmult_le_compat_l; lra).
  assert (A4 : u * pt <= u * (6 * (S' * ((1 + / 2 ^ 17) * HH)))) by (apply Rmult_le_compat_l; lra).
  (* both in units of u·HH *)
  set (w := u * HH) in *. assert (W0 : 0 < w) by (unfold w; apply Rmult_lt_0_compat; lra).
  assert (R1 : w * (h' + 2 * S') <= w * ((1 + / 2 ^ 18) * rho)) by (apply Rmult_le_compat_l; lra).
  replace (w * ((1 + / 2 ^ 18) * rho)) with ((1 + / 2 ^ 18) * (u * X)) in R1 by (unfold w, X; ring).
  replace (u * / 2 ^ 102 * (2 * ((3 * 2 ^ 20 + 8) * (3 * (S' + h'))) * ((2 ^ 34 + 2) ^ 2 * HH)))
    with (/ 2 ^ 102 * 2 * (3 * 2 ^ 20 + 8) * 3 * (2 ^ 34 + 2) ^ 2 * (w * S' + w * h')) in B4 by (unfold w; ring).
  replace (u * (2 * (3 * (S' + h')) * ((1 + / 2 ^ 17) * HH))) with (6 * (1 + / 2 ^ 17) * (w * S' + w * h')) in B5 by (unfold w; ring).
  replace (u * (6 * (S' * ((1 + / 2 ^ 17) * HH)))) with (6 * (1 + / 2 ^ 17) * (w * S')) in A4 by (unfold w; ring).
  assert (0 <= w * S') by (apply Rmult_le_pos; lra). assert (0 <= w * h') by (apply Rmult_le_pos; lra).
  replace (computed T - t * computed det) with ((computed T - exact v T) + - (t * (computed det - exact v det))) by (rewrite <- E; ring).
  eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp, Rabs_mult. unfold FACTOR in L. lra.
Qed.

(** Inside for certain, and with a bound that says something. *)
Hypothesis inside : bound < Rmax (least rnd f fuse stored) (- most rnd f fuse stored).
Hypothesis is_bounded : bound < NO_BOUND.

Lemma det_nonzero : computed det <> 0.
Proof.
  pose proof (use bound_ge) as G. cbv zeta in G. fold rho in G. unfold SHORTEST, SLOWEST in *.
  assert (Q1 : / 2 ^ 88 <= size * h * rho).
  { replace (/ 2 ^ 88) with (/ 2 ^ 20 * / 2 ^ 34 * / 2 ^ 34) by lra. repeat apply Rmult_le_compat; lra. }
  assert (Q2 : u * / 2 ^ 88 <= u * (size * h * rho)) by (apply Rmult_le_compat_l; lra).
  assert (E2 : 2 ^ 14 * eta <= bound) by (unfold FACTOR in G; lra).
  assert (Hw : computed W = rnd (rnd (computed det - computed U) - computed V)).
  { unfold Filter.computed, form. destruct fuse, stored; reflexivity. }
  pose proof (rounded (computed det - computed U)) as R1. set (x := rnd (computed det - computed U)) in *.
  pose proof (rounded (x - computed V)) as R2. rewrite <- Hw in R2.
  assert (Small : forall y y', Rabs (y' - y) <= u * Rabs y + eta ->
    (y < - bound -> y' <= (1 - / 2 ^ 24) * y + eta) /\ (bound < y -> (1 - / 2 ^ 24) * y - eta <= y')).
  { intros y y' N. apply Rabs_le_inv in N. split; intro L.
    - rewrite Rabs_left in N by lra. assert (u * - y <= / 2 ^ 24 * - y) by (apply Rmult_le_compat_r; lra). lra.
    - rewrite Rabs_right in N by lra. assert (u * y <= / 2 ^ 24 * y) by (apply Rmult_le_compat_r; lra). lra. }
  destruct (Small _ _ R1) as [S1 S1']. destruct (Small _ _ R2) as [S2 S2'].
  intro Z. rewrite Z in *. unfold Rmax at 1 in inside. destruct (Rle_dec (least rnd f fuse stored) (- most rnd f fuse stored)) as [O|O]; unfold most, least in *.
  - set (a := Rmax (computed U) (computed V)) in *.
    pose proof (Rmax_l a (computed W)). pose proof (Rmax_r a (computed W)).
    assert (computed U <= a) by apply Rmax_l. assert (computed V <= a) by apply Rmax_r.
    specialize (S1' ltac:(lra)). specialize (S2' ltac:(lra)). lra.
  - set (a := Rmin (computed U) (computed V)) in *.
    pose proof (Rmin_l a (computed W)). pose proof (Rmin_r a (computed W)).
    assert (a <= computed U) by apply Rmin_l. assert (a <= computed V) by apply Rmin_r.
    specialize (S1 ltac:(lra)). specialize (S2 ltac:(lra)). lra.
Qed.

Lemma det_small : eta <= Rabs (1 / computed det).
Proof.
  pose proof det_nonzero as N. assert (D : 0 < Rabs (computed det)) by (apply Rabs_pos_lt; exact N).
  pose proof (use bound_ge) as G. pose proof (use perm_w) as P. pose proof (use volumes_within_bound det ltac:(simpl; tauto)) as V0.
  pose proof (use in_w det ltac:(simpl; tauto)) as (P1 & _). cbv zeta in G, P. fold rho in G, P.
  pose proof (use volume det) as [_ [V1 _]]. set (q := size * h * rho) in *. unfold NO_BOUND, FACTOR in *.
  assert (A : Rabs (computed det) <= 3 * q + 2 ^ 30).
  { assert (Rabs (computed det) <= Rabs (exact v det) + bound).
    { replace (computed det) with (exact v det + (computed det - exact v det)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
    assert (0 < q). { unfold q, SLOWEST, SHORTEST in *. repeat apply Rmult_lt_0_compat; lra. } lra. }
  assert (B : u * Rabs (computed det) <= u * (3 * q + 2 ^ 30)) by (apply Rmult_le_compat_l; lra).
  assert (C : u * Rabs (computed det) <= 2 ^ 31) by lra.
  apply Rmult_le_reg_r with (Rabs (computed det)); [exact D|].
  replace (Rabs (1 / computed det) * Rabs (computed det)) with 1.
  - assert (eta * Rabs (computed det) <= u * / 2 ^ 102 * Rabs (computed det)) by (apply Rmult_le_compat_r; lra). lra.
  - rewrite <- Rabs_mult. replace (1 / computed det * computed det) with 1 by (field; exact N). rewrite Rabs_R1. reflexivity.
Qed.

(** *** [filter::screened] *)

Definition reciprocal := rnd (1 / computed det).
Definition place := rnd (computed T * reciprocal).
Definition of_rounding := mul_add (Rabs place) (rnd (4 * u)) UNDERFLOW.
Definition margin := mul_add (Filter.bound_of_hit rnd u eta f fuse) (Rabs reciprocal) of_rounding.
Definition low := rnd (place - margin).
Definition high := rnd (place + margin).

Lemma of_rounding_ge : 301 / 100 * (u * Rabs place) + 32 / 10 * eta <= of_rounding.
Proof.
  pose proof (Rabs_pos place). unfold of_rounding, Filter.mul_add.
  assert (K : c * (4 * u) <= rnd (4 * u)).
  { apply below'; [|lra]. assert (u * / 2 ^ 102 <= u * 1) by (apply Rmult_le_compat_l; lra). lra. }
  set (k := rnd (4 * u)) in *. assert (KP : Rabs place * (c * (4 * u)) <= Rabs place * k) by (apply Rmult_le_compat_l; lra).
  replace (Rabs place * (c * (4 * u))) with (4 * c * (u * Rabs place)) in KP by ring.
  assert (0 <= u * Rabs place) by (apply Rmult_le_pos; lra).
  assert (F : 4 * eta <= UNDERFLOW) by (unfold UNDERFLOW; lra).
  set (y := u * Rabs place) in *. set (g := Rabs place * k) in *. assert (0 <= g) by (unfold c in *; lra).
  destruct fuse.
  - apply Rle_trans with (c * (g + UNDERFLOW)); [|apply below'; lra]. unfold c in *. lra.
  - pose proof (rounds_sign _ _ _ arithmetic g ltac:(assumption)).
    destruct (Rle_lt_dec eta g) as [L|L].
    + pose proof (below' g g L (Rle_refl g)). apply Rle_trans with (c * (c * g + UNDERFLOW)); [|apply below'; unfold c in *; lra]. unfold c in *. lra.
    + apply Rle_trans with (c * UNDERFLOW); [|apply below'; lra]. unfold c in *. lra.
Qed.

Theorem t_within : low <= t <= high.
Proof.
  pose proof det_nonzero as N. assert (D : 0 < Rabs (computed det)) by (apply Rabs_pos_lt; exact N).
  pose proof numerators as B. pose proof (rounds_normal _ _ _ arithmetic _ det_small) as R. fold reciprocal in R.
  set (b := Filter.bound_of_hit rnd u eta f fuse) in *. pose proof of_rounding_ge as O. set (o := of_rounding) in *.
  set (z := computed T / computed det). set (i := Rabs (1 / computed det)) in *.
  assert (I0 : 0 < i) by (apply Rabs_pos_lt; unfold Rdiv; rewrite Rmult_1_l; apply Rinv_neq_0_compat; exact N).
  assert (Near : Rabs (z - t) <= (1 - / 2 ^ 16) * (b * i)).
  { replace (z - t) with ((computed T - t * computed det) * (1 / computed det)) by (unfold z; field; exact N).
    rewrite Rabs_mult. fold i. replace ((1 - / 2 ^ 16) * (b * i)) with ((1 - / 2 ^ 16) * b * i) by ring. apply Rmult_le_compat_r; lra. }
  assert (b0 : 0 <= b) by (pose proof (Rabs_pos (computed T - t * computed det)); lra).
  assert (Rr : c * i <= Rabs reciprocal).
  { assert (i <= Rabs reciprocal + u * i).
    { unfold i at 1. replace (1 / computed det) with (reciprocal + - (reciprocal - 1 / computed det)) by ring.
      eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
    assert (u * i <= / 2 ^ 24 * i) by (apply Rmult_le_compat_r; lra). unfold c. lra. }
  (* what the quotient's two roundings take *)
  assert (E1 : Rabs (computed T * reciprocal - z) <= u * Rabs z).
  { replace (computed T * reciprocal - z) with (computed T * (reciprocal - 1 / computed det)) by (unfold z; field; exact N).
    rewrite Rabs_mult. replace (u * Rabs z) with (Rabs (computed T) * (u * i)).
    - apply Rmult_le_compat_l; [apply Rabs_pos|exact R].
    - unfold z, i, Rdiv. rewrite !Rabs_mult, Rabs_R1. ring. }
  pose proof (rounded (computed T * reciprocal)) as E2. fold place in E2.
  set (g := computed T * reciprocal) in *. pose proof (Rabs_pos z). pose proof (Rabs_pos place) as P0.
  assert (G : Rabs g <= Rabs z + u * Rabs z).
  { replace g with (z + (g - z)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  assert (UG : u * Rabs g <= u * (Rabs z + u * Rabs z)) by (apply Rmult_le_compat_l; lra).
  assert (UZ0 : 0 <= u * Rabs z) by (apply Rmult_le_pos; lra).
  assert (UUZ : u * (u * Rabs z) <= / 2 ^ 24 * (u * Rabs z)) by (apply Rmult_le_compat_r; lra).
  assert (Dev : Rabs (place - z) <= (2 + / 2 ^ 24) * (u * Rabs z) + eta).
  { replace (place - z) with ((place - g) + (g - z)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  assert (Z : Rabs z <= Rabs place + Rabs (place - z)).
  { replace z with (place + - (place - z)) at 1 by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  set (dev := Rabs (place - z)) in *. assert (dev0 : 0 <= dev) by apply Rabs_pos.
  assert (UZ : u * Rabs z <= u * (Rabs place + dev)) by (apply Rmult_le_compat_l; lra).
  assert (UD : u * dev <= / 2 ^ 24 * dev) by (apply Rmult_le_compat_r; lra).
  set (y := u * Rabs place) in *. assert (Y0 : 0 <= y) by (unfold y; apply Rmult_le_pos; lra).
  assert (Dv : dev <= (2 + / 2 ^ 21) * y + (1 + / 2 ^ 22) * eta) by (unfold y in *; lra).
  (* the margin *)
  assert (BR : b * (c * i) <= b * Rabs reciprocal) by (apply Rmult_le_compat_l; lra).
  set (a := b * i) in *. assert (A0 : 0 <= a) by (unfold a; apply Rmult_le_pos; lra).
  replace (b * (c * i)) with (c * a) in BR by (unfold a; ring).
  set (q := b * Rabs reciprocal) in *.
  assert (M : c * (c * (c * a) - eta + o) <= margin).
  { unfold margin, Filter.mul_add. fold b o q. destruct fuse.
    - apply below'; unfold c in *; lra.
    - pose proof (rounded q) as Rq. rewrite (Rabs_right q) in Rq by (unfold c in *; lra). apply Rabs_le_inv in Rq.
      assert (u * q <= / 2 ^ 24 * q) by (apply Rmult_le_compat_r; unfold c in *; lra).
      apply below'; unfold c in *; lra. }
  assert (M0 : 0 <= margin) by (unfold c in *; lra).
  assert (UM : u * margin <= / 2 ^ 24 * margin) by (apply Rmult_le_compat_r; lra).
  assert (Ends : forall s, Rabs (s - place) <= margin -> Rabs (rnd s - s) <= y + / 2 ^ 24 * margin + eta).
  { intros s Hs. pose proof (rounded s). assert (Rabs s <= Rabs place + margin).
    { replace s with (place + (s - place)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
    assert (u * Rabs s <= u * (Rabs place + margin)) by (apply Rmult_le_compat_l; lra). unfold y in *. lra. }
  assert (Lo := Ends (place - margin)). assert (Hi := Ends (place + margin)).
  assert (Rabs (place - margin - place) <= margin) by (replace (place - margin - place) with (- margin) by ring; rewrite Rabs_Ropp, Rabs_right; lra).
  assert (Rabs (place + margin - place) <= margin) by (replace (place + margin - place) with margin by ring; rewrite Rabs_right; lra).
  specialize (Lo ltac:(assumption)). specialize (Hi ltac:(assumption)). fold low in Lo. fold high in Hi.
  apply Rabs_le_inv in Lo. apply Rabs_le_inv in Hi. apply Rabs_le_inv in Near.
  assert (Pz : - dev <= place - z <= dev) by (apply Rabs_le_inv; apply Rle_refl).
  unfold c in *. lra.
Qed.
End Hit.
