(** The filter of the exact kernel: what it computes as the bound of its errors bounds them, all roundings and
    underflow included; in any precision of at least 24 bits, plain and fused. Names are those of
    crates/methods/exact/src/filter.rs. *)
Require Import List Reals Lra Lia Psatz.
Import ListNotations.
From Flocq Require Import Raux.
Require Import Trisect.Bound Trisect.Float Trisect.Methods Trisect.Norms.
Open Scope R_scope.

(** The constants of the code. *)
Definition SHORTEST := / 2 ^ 34.
Definition NEAREST := / 2 ^ 20.
Definition SLOWEST := / 2 ^ 20.
Definition FACTOR := 18 * (1 + / 2 ^ 9).

Definition largest a b c := Rmax (Rabs a) (Rmax (Rabs b) (Rabs c)).

Lemma largest_ge a b c : Rabs a <= largest a b c /\ Rabs b <= largest a b c /\ Rabs c <= largest a b c.
Proof.
  unfold largest. pose proof (Rmax_l (Rabs a) (Rmax (Rabs b) (Rabs c))).
  pose proof (Rmax_r (Rabs a) (Rmax (Rabs b) (Rabs c))).
  pose proof (Rmax_l (Rabs b) (Rabs c)). pose proof (Rmax_r (Rabs b) (Rabs c)). lra.
Qed.

(** The normal, [(C − A) × (B − A)]. *)
Definition n_x := MulSub (Diff 13 7) (Diff 11 8) (Mul (Diff 14 8) (Diff 10 7)).
Definition n_y := MulSub (Diff 14 8) (Diff 9 6) (Mul (Diff 12 6) (Diff 11 8)).
Definition n_z := MulSub (Diff 12 6) (Diff 10 7) (Mul (Diff 13 7) (Diff 9 6)).
Definition is_normal e := (same e n_x || same e n_y || same e n_z)%bool.

Section Filter.
Set Default Proof Using "All".
Variable rnd : R -> R.
Variables u eta : R.
Hypothesis arithmetic : rounding rnd u eta.
(** At least the precision and the range of f32. *)
Hypothesis precise : 0 < u <= / 2 ^ 24.
Hypothesis wide : 0 <= eta <= u * / 2 ^ 102.
(** The numbers of the pair, and what is read of them. *)
Variables v f : nat -> R.
Hypothesis reads : forall i, Rabs (f i - v i) <= eta.
(** Whether multiply-add is fused, and the normal was stored, which is made in plain arithmetic. *)
Variables fuse stored : bool.

Definition form e := if fuse then fused_but (if stored then is_normal else fun _ => false) e else e.
(** A volume as computed. *)
Definition computed e := float rnd f (form e).
Definition mul_add a b c := if fuse then rnd (a * b + c) else rnd (rnd (a * b) + c).
Definition mul_sub a b c := if fuse then rnd (a * b - c) else rnd (rnd (a * b) - c).
Definition difference i j := rnd (f i - f j).

Definition h := Rmax SHORTEST
  (Rmax (largest (difference 9 6) (difference 10 7) (difference 11 8))
        (largest (difference 12 6) (difference 13 7) (difference 14 8))).
Definition distance := largest (difference 6 0) (difference 7 1) (difference 8 2).
Definition size := rnd (Rabs (f 3%nat) + rnd (Rabs (f 4%nat) + Rabs (f 5%nat))).
Definition unit := rnd (u * FACTOR).
Definition scale := rnd (size * unit).
Definition reach := mul_add distance 2 h.
(** [filter::bound] *)
Definition bound := rnd (rnd (scale * h) * reach).
(** [filter::bound_of_t] *)
Definition bound_of_t := rnd (rnd (h * h) * rnd (Rmax distance NEAREST * rnd (3 * unit))).
(** The bound of [τ·det − T]. *)
Definition bound_at tau := mul_add (Rabs tau) (rnd (rnd (h * h) * scale)) bound_of_t.
(** [filter::bound_of_hit] *)
Definition bound_of_hit := mul_add (rnd (h * h)) (rnd (reach * rnd (3 * unit))) (rnd (8 * eta)).

(** A direction that is not too short to be filtered. *)
Hypothesis is_fast : SLOWEST <= size.

Let one_le_one : 1 <= 1 := Rle_refl 1.
Let u_pos : 0 <= u. Proof. lra. Qed.
Let eta_pos : 0 <= eta. Proof. lra. Qed.
Let rounded := rounds _ _ _ arithmetic.

(** The error of a number that is [near]. *)
Lemma near_error x x' p q k l : near u eta 1 x x' p q k l -> (k <= 16)%nat -> (l <= 32)%nat ->
  Rabs (x' - x) <= INR k * (u * (1 + / 2 ^ 16)) * p + (INR l + / 8) * eta * q.
Proof.
  intros N K L. pose proof (near_within u eta u_pos eta_pos 1 one_le_one _ _ _ _ _ _ N) as E.
  replace (lost eta 1) with eta in E by (unfold lost; field). apply E; lra || assumption.
Qed.

(** A volume is near what it should be. *)
Lemma volume e : near u eta 1 (exact v e) (computed e) (perm v e) (magnitude v 1 e) (depth e) (losses e).
Proof.
  unfold computed, form. destruct fuse; [|apply bounded; assumption].
  set (keep := if stored then is_normal else fun _ => false).
  pose proof (bounded rnd u eta u_pos eta_pos rounded v f reads 1 one_le_one (fused_but keep e)) as N.
  unfold perm in N. rewrite exact_fused, !magnitude_fused in N.
  eapply near_weaken; [exact u_pos|exact eta_pos|exact one_le_one|apply depth_fused|apply losses_fused|exact N].
Qed.

(** Rounding takes from a number that is not subnormal at most [u] of it. *)
Lemma below X x : eta <= X -> X <= x -> (1 - u) * X <= rnd x.
Proof.
  intros E L. pose proof (rounds_normal _ _ _ arithmetic x) as N.
  rewrite (Rabs_right x) in N by lra. specialize (N ltac:(lra)). apply Rabs_le_inv in N.
  assert (u * X <= u * x) by (apply Rmult_le_compat_l; lra).
  assert ((1 - u) * X <= (1 - u) * x) by (apply Rmult_le_compat_l; lra). lra.
Qed.

Lemma eta_below c : / 2 ^ 100 <= c -> eta <= c.
Proof. intro. assert (u * / 2 ^ 102 <= / 2 ^ 24 * / 2 ^ 102) by (apply Rmult_le_compat_r; lra). lra. Qed.

(** *** Sizes *)

Lemma h_ge : SHORTEST <= h. Proof. apply Rmax_l. Qed.
Lemma distance_pos : 0 <= distance.
Proof. pose proof (largest_ge (difference 6 0) (difference 7 1) (difference 8 2)). pose proof (Rabs_pos (difference 6 0)). unfold distance. lra. Qed.

(** A difference is larger than its rounding by so much at most. *)
Lemma difference_le i j : Rabs (v i - v j) <= (1 + / 2 ^ 20) * Rabs (difference i j) + 4 * eta.
Proof.
  unfold difference. set (d := f i - f j). pose proof (rounded d) as N. pose proof (reads i). pose proof (reads j).
  assert (Rabs (v i - v j) <= Rabs d + 2 * eta).
  { replace (v i - v j) with (d + (- (f i - v i) + (f j - v j))) by (unfold d; ring).
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat_l.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  assert (Rabs d <= Rabs (rnd d) + (u * Rabs d + eta)).
  { replace d with (rnd d + - (rnd d - d)) at 1 by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  pose proof (Rabs_pos d). pose proof (Rabs_pos (rnd d)).
  assert (u * Rabs d <= / 2 ^ 24 * Rabs d) by (apply Rmult_le_compat_r; lra). lra.
Qed.

(** Bounds of what is meant, from what is computed. *)
Definition S' := (1 + / 2 ^ 20) * distance + 4 * eta.
Definition h' := (1 + / 2 ^ 19) * h.

Lemma is_sized : sized v S' h'.
Proof.
  assert (B : forall i j, Rabs (difference i j) <= distance -> Rabs (v i - v j) <= S').
  { intros i j D. pose proof (difference_le i j). unfold S'. lra. }
  assert (E : forall i j, Rabs (difference i j) <= h -> Rabs (v i - v j) <= h').
  { intros i j D. pose proof (difference_le i j). unfold h'. pose proof h_ge. unfold SHORTEST in *.
    pose proof (eta_below (/ 2 ^ 60) ltac:(lra)). lra. }
  pose proof (largest_ge (difference 6 0) (difference 7 1) (difference 8 2)) as (?&?&?).
  assert (Hh : forall a, Rabs a <= largest (difference 9 6) (difference 10 7) (difference 11 8) \/
                        Rabs a <= largest (difference 12 6) (difference 13 7) (difference 14 8) -> Rabs a <= h).
  { intros a A. unfold h. eapply Rle_trans; [|apply Rmax_r].
    destruct A; eapply Rle_trans; try eassumption; [apply Rmax_l|apply Rmax_r]. }
  pose proof (largest_ge (difference 9 6) (difference 10 7) (difference 11 8)) as (?&?&?).
  pose proof (largest_ge (difference 12 6) (difference 13 7) (difference 14 8)) as (?&?&?).
  split; auto.
Qed.

Lemma d1_le : d1 v <= (1 + / 2 ^ 19) * size.
Proof.
  assert (A : forall i, Rabs (v i) <= Rabs (f i) + eta).
  { intro i. pose proof (reads i). replace (v i) with (f i + - (f i - v i)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  pose proof (A 3%nat). pose proof (A 4%nat). pose proof (A 5%nat). unfold d1, size in *.
  set (x := Rabs (f 3%nat)) in *. set (y := Rabs (f 4%nat) + Rabs (f 5%nat)) in *.
  pose proof (Rabs_pos (f 3%nat)). pose proof (Rabs_pos (f 4%nat)). pose proof (Rabs_pos (f 5%nat)).
  assert (L : forall z, 0 <= z -> (1 - / 2 ^ 24) * z - eta <= rnd z).
  { intros z Z. pose proof (rounded z) as N. rewrite (Rabs_right z) in N by lra. apply Rabs_le_inv in N.
    assert (u * z <= / 2 ^ 24 * z) by (apply Rmult_le_compat_r; lra). lra. }
  pose proof (L y ltac:(unfold y; lra)) as Y.
  assert (X : (1 - / 2 ^ 24) * (x + rnd y) - eta <= rnd (x + rnd y)).
  { destruct (Rle_lt_dec 0 (x + rnd y)) as [P|P]; [apply L; exact P|].
    exfalso. pose proof (rounded (x + rnd y)) as N. rewrite (Rabs_left (x + rnd y)) in N by lra. apply Rabs_le_inv in N.
    assert (u * - (x + rnd y) <= 1 * - (x + rnd y)) by (apply Rmult_le_compat_r; lra).
    unfold SLOWEST in is_fast. pose proof (eta_below (/ 2 ^ 60) ltac:(lra)). lra. }
  unfold SLOWEST in is_fast. pose proof (eta_below (/ 2 ^ 60) ltac:(lra)). unfold y, x in *. lra.
Qed.

(** *** The bounds from below *)

Let c := 1 - / 2 ^ 24.
Lemma below_c X x : eta <= X -> X <= x -> c * X <= rnd x.
Proof.
  intros E L. pose proof (below X x E L). assert (u * X <= / 2 ^ 24 * X) by (apply Rmult_le_compat_r; lra).
  unfold c. lra.
Qed.

Lemma size_pos : 0 < size. Proof. unfold SLOWEST in is_fast. lra. Qed.
Lemma h_pos : 0 < h. Proof. pose proof h_ge. unfold SHORTEST in *. lra. Qed.
Let rho := h + 2 * distance.
Lemma rho_ge : SHORTEST <= rho.
Proof. pose proof h_ge. pose proof distance_pos. unfold rho. lra. Qed.

Lemma unit_ge : c * (u * FACTOR) <= unit.
Proof. apply below_c; [|lra]. unfold FACTOR. assert (u * / 2 ^ 102 <= u * 1) by (apply Rmult_le_compat_l; lra). lra. Qed.

Lemma reach_ge : (1 - / 2 ^ 22) * rho <= reach.
Proof.
  pose proof h_ge. pose proof distance_pos. pose proof (eta_below (/ 2 ^ 60) ltac:(lra)).
  unfold reach, mul_add, rho, SHORTEST in *. destruct fuse.
  - pose proof (below_c (h + 2 * distance) (distance * 2 + h) ltac:(lra) ltac:(lra)). unfold c in *. lra.
  - pose proof (rounded (distance * 2)) as N. rewrite (Rabs_right (distance * 2)) in N by lra. apply Rabs_le_inv in N.
    assert (u * (distance * 2) <= / 2 ^ 24 * (distance * 2)) by (apply Rmult_le_compat_r; lra).
    pose proof (below_c ((1 - / 2 ^ 23) * (h + 2 * distance)) (rnd (distance * 2) + h) ltac:(lra) ltac:(lra)).
    unfold c in *. lra.
Qed.

Lemma scale_ge : c * c * (u * FACTOR) * size <= scale.
Proof.
  pose proof unit_ge. pose proof size_pos. unfold scale.
  assert (size * (c * (u * FACTOR)) <= size * unit) by (apply Rmult_le_compat_l; lra).
  assert (/ 2 ^ 20 * (c * (u * FACTOR)) <= size * (c * (u * FACTOR))).
  { apply Rmult_le_compat_r; [unfold c, FACTOR; lra|exact is_fast]. }
  pose proof (below_c (size * (c * (u * FACTOR))) (size * unit)) as B.
  assert (eta <= size * (c * (u * FACTOR))) by (unfold c, FACTOR in *; lra).
  specialize (B ltac:(assumption) ltac:(assumption)). lra.
Qed.

Lemma scale_large : 17 * / 2 ^ 20 * u <= scale.
Proof.
  pose proof scale_ge. pose proof is_fast. unfold SLOWEST in *.
  assert (c * c * (u * FACTOR) * / 2 ^ 20 <= c * c * (u * FACTOR) * size).
  { apply Rmult_le_compat_l; [unfold c, FACTOR|]; lra. }
  unfold c, FACTOR in *. lra.
Qed.

Let Q := size * h * rho.
Lemma Q_pos : 0 < Q.
Proof. pose proof size_pos. pose proof h_pos. pose proof rho_ge. unfold SHORTEST in *. unfold Q. repeat apply Rmult_lt_0_compat; lra. Qed.

Theorem bound_ge : (1 - / 2 ^ 20) * FACTOR * (u * Q) <= bound.
Proof.
  pose proof scale_ge as K. pose proof scale_large as L. pose proof reach_ge as R. pose proof h_ge as H. pose proof rho_ge as P.
  pose proof size_pos as D. unfold SHORTEST in *.
  assert (A : 17 * / 2 ^ 20 * u * / 2 ^ 34 <= scale * h) by (apply Rmult_le_compat; lra).
  pose proof (below_c (scale * h) (scale * h) ltac:(lra) ltac:(lra)) as B.
  assert (B' : 16 * / 2 ^ 54 * u <= rnd (scale * h)) by (unfold c in *; lra).
  assert (E : (16 * / 2 ^ 54 * u) * (/ 2 ^ 35) <= rnd (scale * h) * reach) by (apply Rmult_le_compat; lra).
  pose proof (below_c _ _ (ltac:(lra) : eta <= rnd (scale * h) * reach) (Rle_refl _)) as F.
  assert (G : c * (c * c * (u * FACTOR) * size * h) * ((1 - / 2 ^ 22) * rho) <= rnd (scale * h) * reach).
  { apply Rmult_le_compat; try lra.
    - assert (0 <= size * h) by (apply Rmult_le_pos; lra).
      replace (c * (c * c * (u * FACTOR) * size * h)) with (c * c * c * FACTOR * (u * (size * h))) by ring.
      repeat apply Rmult_le_pos; unfold c, FACTOR; lra.
    - eapply Rle_trans; [|exact B]. apply Rmult_le_compat_l; [unfold c; lra|].
      apply Rmult_le_compat_r; lra. }
  unfold bound. eapply Rle_trans; [|exact F]. eapply Rle_trans; [|apply Rmult_le_compat_l; [unfold c; lra|exact G]].
  replace (c * (c * (c * c * (u * FACTOR) * size * h) * ((1 - / 2 ^ 22) * rho)))
    with (c * c * c * c * (1 - / 2 ^ 22) * FACTOR * (u * Q)) by (unfold Q; ring).
  apply Rmult_le_compat_r; [apply Rmult_le_pos; [lra|left; exact Q_pos]|].
  apply Rmult_le_compat_r; unfold c, FACTOR; lra.
Qed.

(** *** The volumes *)

Lemma h'_plus : h' + 1 <= (2 ^ 34 + 2) * h.
Proof. pose proof h_ge. unfold h', SHORTEST in *. lra. Qed.
Lemma d_plus : d1 v + 3 <= (3 * 2 ^ 20 + 2) * size.
Proof. pose proof d1_le. unfold SLOWEST in is_fast. lra. Qed.
Lemma d1_pos : 0 <= d1 v.
Proof. unfold d1. pose proof (Rabs_pos (v 3%nat)). pose proof (Rabs_pos (v 4%nat)). pose proof (Rabs_pos (v 5%nat)). lra. Qed.
Lemma S'_pos : 0 <= S'. Proof. pose proof distance_pos. unfold S'. lra. Qed.
Lemma rho'_le : h' + 2 * S' <= (1 + / 2 ^ 18) * rho.
Proof. pose proof h_ge. pose proof distance_pos. pose proof (eta_below (/ 2 ^ 60) ltac:(lra)). unfold h', S', rho, SHORTEST in *. lra. Qed.

Lemma perm_w : perm v W <= 2 * (1 + / 2 ^ 16) * Q.
Proof.
  unfold perm. pose proof (w_norm v S' h' 0 is_sized (Rle_refl 0)) as N. eapply Rle_trans; [exact N|].
  pose proof d1_le. pose proof d1_pos. pose proof rho'_le. pose proof size_pos. pose proof h_pos. pose proof rho_ge.
  pose proof S'_pos. unfold SHORTEST in *.
  assert (0 <= h') by (unfold h'; lra).
  replace (2 * (d1 v + 3 * 0) * (h' + 0) * (h' + 0 + 2 * (S' + 0))) with (2 * (d1 v * h' * (h' + 2 * S'))) by ring.
  assert (A : d1 v * h' * (h' + 2 * S') <= ((1 + / 2 ^ 19) * size) * ((1 + / 2 ^ 19) * h) * ((1 + / 2 ^ 18) * rho)).
  { apply Rmult_le_compat; try lra; [apply Rmult_le_pos; lra|].
    apply Rmult_le_compat; try lra. unfold h'. lra. }
  pose proof Q_pos. replace (((1 + / 2 ^ 19) * size) * ((1 + / 2 ^ 19) * h) * ((1 + / 2 ^ 18) * rho))
    with ((1 + / 2 ^ 19) * (1 + / 2 ^ 19) * (1 + / 2 ^ 18) * Q) in A by (unfold Q; ring). lra.
Qed.

Lemma lost_w : magnitude v 1 W <= 2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) * (3 * 2 ^ 34 + 2) * Q.
Proof.
  pose proof (w_norm v S' h' 1 is_sized Rle_0_1) as N. eapply Rle_trans; [exact N|].
  pose proof d_plus. pose proof d1_pos. pose proof rho'_le. pose proof size_pos. pose proof h_pos. pose proof rho_ge.
  pose proof S'_pos. pose proof h'_plus. unfold SHORTEST in *.
  assert (0 <= h') by (unfold h'; lra).
  replace (2 * (d1 v + 3 * 1) * (h' + 1) * (h' + 1 + 2 * (S' + 1)))
    with (2 * ((d1 v + 3) * (h' + 1) * (h' + 2 * S' + 3))) by ring.
  assert (A : (d1 v + 3) * (h' + 1) * (h' + 2 * S' + 3)
    <= ((3 * 2 ^ 20 + 2) * size) * ((2 ^ 34 + 2) * h) * ((3 * 2 ^ 34 + 2) * rho)).
  { apply Rmult_le_compat; try lra; [apply Rmult_le_pos; lra|]. apply Rmult_le_compat; lra. }
  unfold Q. lra.
Qed.

(** What all volumes have in common: their permanents are parts of that of [W], whose terms are longest. *)
Lemma volume_error x x' p q k l : near u eta 1 x x' p q k l -> (k <= 9)%nat -> (l <= 16)%nat ->
  p <= perm v W -> q <= magnitude v 1 W -> Rabs (x' - x) <= bound.
Proof.
  intros N K L P M. pose proof N as [_ [N0 N1]]. pose proof (Rabs_pos x).
  apply (near_weaken u eta u_pos eta_pos 1 one_le_one) with (k' := 9%nat) (l' := 16%nat) in N; [|assumption|assumption].
  pose proof (near_error _ _ _ _ _ _ N ltac:(lia) ltac:(lia)) as E.
  replace (INR 9) with 9 in E by (simpl; lra). replace (INR 16) with 16 in E by (simpl; lra).
  pose proof perm_w. pose proof lost_w. pose proof bound_ge as B. pose proof Q_pos.
  assert (9 * (u * (1 + / 2 ^ 16)) * p <= 9 * (u * (1 + / 2 ^ 16)) * (2 * (1 + / 2 ^ 16) * Q)) by (apply Rmult_le_compat_l; lra).
  assert ((16 + / 8) * eta * q <= (16 + / 8) * (u * / 2 ^ 102) * (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) * (3 * 2 ^ 34 + 2) * Q)).
  { apply Rmult_le_compat; lra. }
  assert (0 < u * Q) by (apply Rmult_lt_0_compat; lra).
  unfold FACTOR in *. lra.
Qed.

Lemma in_w e : List.In e [det; U; V; W] ->
  perm v e <= perm v W /\ magnitude v 1 e <= magnitude v 1 W /\ (depth e <= 9)%nat /\ (losses e <= 16)%nat.
Proof.
  assert (D : forall m, magnitude v m W = magnitude v m det + magnitude v m U + magnitude v m V) by reflexivity.
  unfold perm. rewrite !D.
  assert (P : forall m e, 0 <= m -> 0 <= magnitude v m e) by (intros; apply magnitude_pos; assumption).
  pose proof (P 0 det ltac:(lra)). pose proof (P 0 U ltac:(lra)). pose proof (P 0 V ltac:(lra)).
  pose proof (P 1 det ltac:(lra)). pose proof (P 1 U ltac:(lra)). pose proof (P 1 V ltac:(lra)).
  intros [<-|[<-|[<-|[<-|[]]]]]; rewrite ?D; repeat split; try lra; apply PeanoNat.Nat.leb_le; reflexivity.
Qed.

(** [det], [U], [V] and [W] are off by no more than the bound, as it is computed. *)
Theorem volumes_within_bound e : List.In e [det; U; V; W] ->
  Rabs (computed e - exact v e) <= bound.
Proof.
  intro E. apply in_w in E. destruct E as (P & M & K & L).
  exact (volume_error _ _ _ _ _ _ (volume e) K L P M).
Qed.

(** *** Decisions *)

Definition most := Rmax (Rmax (computed U) (computed V)) (computed W).
Definition least := Rmin (Rmin (computed U) (computed V)) (computed W).

Lemma signs : forall e, List.In e [U; V; W] -> Rabs (computed e - exact v e) <= bound.
Proof. intros e E. apply volumes_within_bound. right. exact E. Qed.

(** What the filter calls a certain miss is one: no point of the line is one of the triangle. *)
Theorem certain_miss : bound < Rmin most (- least) ->
  forall t beta gamma, meets v t beta gamma -> 0 <= beta -> 0 <= gamma -> beta + gamma <= 1 -> False.
Proof.
  intros H t beta gamma M P P' P''. destruct (meets_volumes v _ _ _ M) as (_ & X & Y & Z).
  pose proof (signs U ltac:(simpl; auto)) as A. pose proof (signs V ltac:(simpl; auto)) as B. pose proof (signs W ltac:(simpl; auto)) as C.
  apply Rabs_le_inv in A. apply Rabs_le_inv in B. apply Rabs_le_inv in C.
  assert (H1 : bound < most) by (eapply Rlt_le_trans; [exact H|apply Rmin_l]).
  assert (H2 : bound < - least) by (eapply Rlt_le_trans; [exact H|apply Rmin_r]).
  unfold most, least in *.
  assert (L : exact v U < 0 \/ exact v V < 0 \/ exact v W < 0).
  { unfold Rmin in H2. repeat destruct (Rle_dec _ _) in H2; lra. }
  assert (G : exact v U > 0 \/ exact v V > 0 \/ exact v W > 0).
  { unfold Rmax in H1. repeat destruct (Rle_dec _ _) in H1; lra. }
  destruct (Rle_lt_dec 0 (exact v det)).
  - assert (0 <= beta * exact v det) by (apply Rmult_le_pos; lra).
    assert (0 <= gamma * exact v det) by (apply Rmult_le_pos; lra).
    assert (0 <= (1 - beta - gamma) * exact v det) by (apply Rmult_le_pos; lra). lra.
  - assert (0 <= beta * - exact v det) by (apply Rmult_le_pos; lra).
    assert (0 <= gamma * - exact v det) by (apply Rmult_le_pos; lra).
    assert (0 <= (1 - beta - gamma) * - exact v det) by (apply Rmult_le_pos; lra). lra.
Qed.

(** What it calls certainly inside is so: the three volumes have the sign of [U] as computed, and [det] has it. *)
Theorem certainly_inside : bound < Rmax least (- most) ->
  (0 < computed U /\ 0 < exact v U /\ 0 < exact v V /\ 0 < exact v W /\ 0 < exact v det) \/
  (computed U < 0 /\ exact v U < 0 /\ exact v V < 0 /\ exact v W < 0 /\ exact v det < 0).
Proof.
  intro H.
  pose proof (signs U ltac:(simpl; auto)) as A. pose proof (signs V ltac:(simpl; auto)) as B. pose proof (signs W ltac:(simpl; auto)) as C.
  pose proof (Rabs_pos (computed U - exact v U)).
  apply Rabs_le_inv in A. apply Rabs_le_inv in B. apply Rabs_le_inv in C.
  pose proof (sum_of_volumes v).
  unfold Rmax at 1 in H. destruct (Rle_dec least (- most)) in H; [right|left]; unfold most, least in *.
  - set (a := Rmax (computed U) (computed V)) in *.
    pose proof (Rmax_l a (computed W)). pose proof (Rmax_r a (computed W)).
    pose proof (Rmax_l (computed U) (computed V)). pose proof (Rmax_r (computed U) (computed V)). unfold a in *. lra.
  - set (a := Rmin (computed U) (computed V)) in *.
    pose proof (Rmin_l a (computed W)). pose proof (Rmin_r a (computed W)).
    pose proof (Rmin_l (computed U) (computed V)). pose proof (Rmin_r (computed U) (computed V)). unfold a in *. lra.
Qed.

(** *** In time *)

Let away := Rmax distance NEAREST.
Lemma away_ge : NEAREST <= away /\ distance <= away.
Proof. split; [apply Rmax_r|apply Rmax_l]. Qed.

Lemma hh_ge : c * (h * h) <= rnd (h * h) /\ / 2 ^ 68 <= h * h.
Proof.
  pose proof h_ge. unfold SHORTEST in *.
  assert (/ 2 ^ 34 * / 2 ^ 34 <= h * h) by (apply Rmult_le_compat; lra).
  pose proof (eta_below (/ 2 ^ 70) ltac:(lra)). split; [apply below_c|]; lra.
Qed.

Lemma three_unit_ge : c * c * (3 * (u * FACTOR)) <= rnd (3 * unit) /\ 53 * u <= rnd (3 * unit).
Proof.
  pose proof unit_ge as K.
  assert (E : eta <= 3 * (c * (u * FACTOR))).
  { unfold c, FACTOR. assert (u * / 2 ^ 102 <= u * 1) by (apply Rmult_le_compat_l; lra). lra. }
  pose proof (below_c (3 * (c * (u * FACTOR))) (3 * unit) E ltac:(lra)). split; [lra|]. unfold c, FACTOR in *. lra.
Qed.

Lemma bound_of_t_ge : (1 - / 2 ^ 20) * (3 * FACTOR) * (u * (h * h * away)) <= bound_of_t
  /\ / 2 ^ 85 * u <= bound_of_t.
Proof.
  destruct hh_ge as [A A']. destruct three_unit_ge as [B B']. destruct away_ge as [L _]. unfold NEAREST in L.
  assert (C : / 2 ^ 20 * (53 * u) <= away * rnd (3 * unit)) by (apply Rmult_le_compat; lra).
  pose proof (below_c (away * rnd (3 * unit)) _ ltac:(lra) (Rle_refl _)) as D.
  assert (D' : / 2 ^ 20 * (52 * u) <= rnd (away * rnd (3 * unit))) by (unfold c in *; lra).
  assert (E : / 2 ^ 68 * c * (/ 2 ^ 20 * (52 * u)) <= rnd (h * h) * rnd (away * rnd (3 * unit))).
  { apply Rmult_le_compat; unfold c in *; lra. }
  assert (E' : / 2 ^ 84 * u <= rnd (h * h) * rnd (away * rnd (3 * unit))) by (unfold c in *; lra).
  pose proof (below_c _ _ (ltac:(lra) : eta <= rnd (h * h) * rnd (away * rnd (3 * unit))) (Rle_refl _)) as F.
  fold away in F. unfold bound_of_t. fold away. split; [|unfold c in *; lra].
  eapply Rle_trans; [|exact F].
  assert (G : c * (h * h) * (c * (away * (c * c * (3 * (u * FACTOR))))) <= rnd (h * h) * rnd (away * rnd (3 * unit))).
  { apply Rmult_le_compat; try lra.
    - unfold c; lra.
    - apply Rmult_le_pos; [unfold c; lra|]. apply Rmult_le_pos; [lra|]. unfold c, FACTOR; lra.
    - eapply Rle_trans; [|exact D]. apply Rmult_le_compat_l; [unfold c; lra|]. apply Rmult_le_compat_l; lra. }
  eapply Rle_trans; [|apply Rmult_le_compat_l; [unfold c; lra|exact G]].
  assert (0 <= u * (h * h * away)) by (apply Rmult_le_pos; [lra|]; apply Rmult_le_pos; lra).
  replace (c * (c * (h * h) * (c * (away * (c * c * (3 * (u * FACTOR)))))))
    with (c * c * c * c * c * (3 * FACTOR) * (u * (h * h * away))) by ring.
  apply Rmult_le_compat_r; [assumption|]. apply Rmult_le_compat_r; unfold c, FACTOR; lra.
Qed.

Theorem bound_at_ge tau :
  (1 - / 2 ^ 16) * FACTOR * (u * (h * h * (3 * away + Rabs tau * size))) <= bound_at tau.
Proof.
  destruct hh_ge as [A A']. pose proof scale_ge as K. pose proof scale_large as L. destruct bound_of_t_ge as [B B'].
  pose proof size_pos as D. pose proof (Rabs_pos tau) as T0. destruct away_ge as [L' _]. unfold NEAREST in L'.
  assert (E : / 2 ^ 68 * c * (17 * / 2 ^ 20 * u) <= rnd (h * h) * scale) by (apply Rmult_le_compat; unfold c in *; lra).
  pose proof (below_c (rnd (h * h) * scale) _ ltac:(unfold c in *; lra) (Rle_refl _)) as F.
  assert (G : c * (h * h) * (c * c * (u * FACTOR) * size) <= rnd (h * h) * scale).
  { apply Rmult_le_compat; try lra; [unfold c; lra|]. apply Rmult_le_pos; [unfold c, FACTOR|]; lra. }
  set (p := rnd (rnd (h * h) * scale)) in *. set (q := bound_of_t) in *.
  assert (M : Rabs tau * (c * (c * (h * h) * (c * c * (u * FACTOR) * size))) <= Rabs tau * p).
  { apply Rmult_le_compat_l; [exact T0|]. eapply Rle_trans; [|exact F]. apply Rmult_le_compat_l; [unfold c|]; lra. }
  set (z := u * (h * h * (Rabs tau * size))).
  assert (Z : 0 <= z).
  { pose proof h_pos. unfold z. repeat apply Rmult_le_pos; lra. }
  replace (Rabs tau * (c * (c * (h * h) * (c * c * (u * FACTOR) * size)))) with (c * c * c * c * FACTOR * z) in M by (unfold z; ring).
  assert (M' : (1 - / 2 ^ 21) * FACTOR * z <= c * c * c * c * FACTOR * z).
  { apply Rmult_le_compat_r; [exact Z|]. apply Rmult_le_compat_r; unfold c, FACTOR; lra. }
  assert (P : 0 <= Rabs tau * p).
  { assert (0 <= (1 - / 2 ^ 21) * FACTOR * z) by (apply Rmult_le_pos; [unfold FACTOR; lra|exact Z]). lra. }
  set (y := u * (h * h * away)) in *.
  replace (u * (h * h * (3 * away + Rabs tau * size))) with (3 * y + z) by (unfold y, z; ring).
  assert (Q0 : eta <= / 2 ^ 17 * q) by lra.
  unfold bound_at, mul_add. fold p q. fold away in q.
  assert (N : c * ((1 - / 2 ^ 24) * (Rabs tau * p) - eta + q) <= (if fuse then rnd (Rabs tau * p + q) else rnd (rnd (Rabs tau * p) + q))).
  { destruct fuse.
    - eapply Rle_trans; [|apply below_c with (X := (1 - / 2 ^ 24) * (Rabs tau * p) - eta + q)]; lra.
    - pose proof (rounded (Rabs tau * p)) as O. rewrite (Rabs_right (Rabs tau * p)) in O by lra. apply Rabs_le_inv in O.
      assert (u * (Rabs tau * p) <= / 2 ^ 24 * (Rabs tau * p)) by (apply Rmult_le_compat_r; lra).
      apply below_c; lra. }
  eapply Rle_trans; [|exact N]. unfold c, FACTOR in *. lra.
Qed.

Lemma S'_le : S' <= (1 + / 2 ^ 19) * away /\ S' + 1 <= (2 ^ 20 + 2) * away.
Proof. destruct away_ge as [A B]. pose proof (eta_below (/ 2 ^ 60) ltac:(lra)). unfold S', NEAREST in *. lra. Qed.

Lemma square_le a b c0 : 0 <= a -> 0 <= b -> a <= c0 * b -> a ^ 2 <= c0 ^ 2 * (b * b).
Proof. intros. replace (c0 ^ 2 * (b * b)) with ((c0 * b) * (c0 * b)) by ring. simpl. rewrite Rmult_1_r. apply Rmult_le_compat; lra. Qed.

Let HH := h * h.
Lemma h_squares : (h' + 0) ^ 2 <= (1 + / 2 ^ 19) ^ 2 * HH /\ (h' + 1) ^ 2 <= (2 ^ 34 + 2) ^ 2 * HH /\ 0 < HH.
Proof.
  pose proof h_pos. pose proof h'_plus. unfold h' in *.
  split; [|split]; [apply square_le; lra|apply square_le; lra|unfold HH; apply Rmult_lt_0_compat; lra].
Qed.

Lemma det_sizes : perm v det <= 2 * (1 + / 2 ^ 17) * (size * HH) /\
  magnitude v 1 det <= 2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * (size * HH).
Proof.
  destruct h_squares as (A & B & C). pose proof d1_le. pose proof d1_pos. pose proof size_pos. pose proof d_plus.
  pose proof (det_norm v S' h' 0 is_sized (Rle_refl 0)) as P. pose proof (det_norm v S' h' 1 is_sized Rle_0_1) as M.
  assert (0 <= (h' + 0) ^ 2) by apply pow2_ge_0. assert (0 <= (h' + 1) ^ 2) by apply pow2_ge_0.
  assert ((d1 v + 3 * 0) * (h' + 0) ^ 2 <= ((1 + / 2 ^ 19) * size) * ((1 + / 2 ^ 19) ^ 2 * HH)) by (apply Rmult_le_compat; lra).
  assert ((d1 v + 3 * 1) * (h' + 1) ^ 2 <= ((3 * 2 ^ 20 + 2) * size) * ((2 ^ 34 + 2) ^ 2 * HH)) by (apply Rmult_le_compat; lra).
  assert (0 < size * HH) by (apply Rmult_lt_0_compat; lra).
  unfold perm. set (X := size * HH) in *. split.
  - replace ((1 + / 2 ^ 19) * size * ((1 + / 2 ^ 19) ^ 2 * HH)) with ((1 + / 2 ^ 19) * (1 + / 2 ^ 19) ^ 2 * X) in * by (unfold X; ring).
    lra.
  - replace ((3 * 2 ^ 20 + 2) * size * ((2 ^ 34 + 2) ^ 2 * HH)) with ((3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * X) in * by (unfold X; ring).
    lra.
Qed.

Lemma t_sizes : perm v T <= 6 * (1 + / 2 ^ 17) * (away * HH) /\
  magnitude v 1 T <= 6 * (2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * (away * HH).
Proof.
  destruct h_squares as (A & B & C). destruct S'_le as [D E]. pose proof S'_pos. destruct away_ge as [F _]. unfold NEAREST in F.
  pose proof (t_norm v S' h' 0 is_sized (Rle_refl 0)) as P. pose proof (t_norm v S' h' 1 is_sized Rle_0_1) as M.
  assert (0 <= (h' + 0) ^ 2) by apply pow2_ge_0. assert (0 <= (h' + 1) ^ 2) by apply pow2_ge_0.
  assert ((S' + 0) * (h' + 0) ^ 2 <= ((1 + / 2 ^ 19) * away) * ((1 + / 2 ^ 19) ^ 2 * HH)) by (apply Rmult_le_compat; lra).
  assert ((S' + 1) * (h' + 1) ^ 2 <= ((2 ^ 20 + 2) * away) * ((2 ^ 34 + 2) ^ 2 * HH)) by (apply Rmult_le_compat; lra).
  assert (0 < away * HH) by (apply Rmult_lt_0_compat; lra).
  unfold perm. set (X := away * HH) in *. split.
  - replace ((1 + / 2 ^ 19) * away * ((1 + / 2 ^ 19) ^ 2 * HH)) with ((1 + / 2 ^ 19) * (1 + / 2 ^ 19) ^ 2 * X) in * by (unfold X; ring).
    lra.
  - replace ((2 ^ 20 + 2) * away * ((2 ^ 34 + 2) ^ 2 * HH)) with ((2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * X) in * by (unfold X; ring).
    lra.
Qed.

(** [τ·det − T] is off by no more than its bound, with the signs turned or not. *)
Theorem row_within_bound tau s : s = 1 \/ s = -1 ->
  Rabs (mul_sub tau (s * computed det) (s * computed T) - s * (tau * exact v det - exact v T)) <= bound_at tau.
Proof.
  intro Hs. destruct det_sizes as [P M]. destruct t_sizes as [P' M']. pose proof (bound_at_ge tau) as B.
  pose proof (Rabs_pos tau) as T0.
  pose proof (near_sign u eta 1 s _ _ _ _ _ _ Hs (volume det)) as D.
  pose proof (near_sign u eta 1 s _ _ _ _ _ _ Hs (volume T)) as N.
  pose proof (large v 1 one_le_one T) as L.
  assert (L' : 0 <= magnitude v 1 det) by (apply magnitude_pos; lra).
  set (md := magnitude v 1 det) in *. set (mt := magnitude v 1 T) in *. set (pd := perm v det) in *. set (pt := perm v T) in *.
  assert (TD : near u eta 1 (tau * (s * exact v det)) (tau * (s * computed det)) (Rabs tau * pd) (Rabs tau * md + mt) 7 12).
  { assert (D' : near u eta 1 (s * exact v det) (s * computed det) pd md 7 12).
    { eapply near_weaken; [exact u_pos|exact eta_pos|exact one_le_one| | |exact D]; apply PeanoNat.Nat.leb_le; reflexivity. }
    assert (D0 : near u eta 1 tau tau (Rabs tau) (Rabs tau) 0 0) by (apply near_refl; lra).
    pose proof (near_mul u eta u_pos eta_pos 1 one_le_one _ _ _ _ _ _ _ _ _ _ _ _ D0 D') as X.
    eapply near_more; [exact u_pos|exact eta_pos|exact one_le_one| |exact X]. lra. }
  assert (L2 : 1 <= Rabs tau * md + mt).
  { assert (0 <= Rabs tau * md) by (apply Rmult_le_pos; assumption). lra. }
  assert (R : near u eta 1 (s * (tau * exact v det - exact v T)) (mul_sub tau (s * computed det) (s * computed T))
              (Rabs tau * pd + pt) ((Rabs tau * md + mt) + mt) 9 16).
  { replace (s * (tau * exact v det - exact v T)) with (tau * (s * exact v det) - s * exact v T) by ring.
    assert (N' : near u eta 1 (s * exact v T) (s * computed T) pt mt 8 15).
    { eapply near_weaken; [exact u_pos|exact eta_pos|exact one_le_one| | |exact N]; apply PeanoNat.Nat.leb_le; reflexivity. }
    unfold mul_sub. destruct fuse.
    - apply near_rnd; try assumption; try exact one_le_one; [lra|]. apply near_sub; [|exact N'].
      eapply near_weaken; [exact u_pos|exact eta_pos|exact one_le_one| | |exact TD]; lia.
    - apply near_rnd; try assumption; try exact one_le_one; [lra|]. apply near_sub; [|exact N'].
      eapply near_weaken; [exact u_pos|exact eta_pos|exact one_le_one| | |apply near_rnd; try assumption; try exact one_le_one; exact TD]; lia. }
  pose proof (near_error _ _ _ _ _ _ R ltac:(lia) ltac:(lia)) as E.
  replace (INR 9) with 9 in E by (simpl; lra). replace (INR 16) with 16 in E by (simpl; lra).
  destruct h_squares as (_ & _ & C). pose proof size_pos. destruct away_ge as [F _]. unfold NEAREST in F.
  fold HH in B. set (X := away * HH) in *. set (Y := Rabs tau * (size * HH)).
  assert (0 < X) by (apply Rmult_lt_0_compat; lra).
  assert (0 < size * HH) by (apply Rmult_lt_0_compat; lra).
  assert (0 <= Y) by (apply Rmult_le_pos; lra).
  assert (A1 : Rabs tau * pd <= Rabs tau * (2 * (1 + / 2 ^ 17) * (size * HH))) by (apply Rmult_le_compat_l; lra).
  assert (A2 : Rabs tau * md <= Rabs tau * (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * (size * HH))) by (apply Rmult_le_compat_l; lra).
  replace (Rabs tau * (2 * (1 + / 2 ^ 17) * (size * HH))) with (2 * (1 + / 2 ^ 17) * Y) in A1 by (unfold Y; ring).
  replace (Rabs tau * (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * (size * HH)))
    with (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * Y) in A2 by (unfold Y; ring).
  replace (u * (HH * (3 * away + Rabs tau * size))) with (3 * (u * X) + u * Y) in B by (unfold X, Y; ring).
  assert (E1 : 9 * (u * (1 + / 2 ^ 16)) * (Rabs tau * pd + pt)
    <= 9 * (u * (1 + / 2 ^ 16)) * (2 * (1 + / 2 ^ 17) * Y + 6 * (1 + / 2 ^ 17) * X)) by (apply Rmult_le_compat_l; lra).
  assert (E2 : (16 + / 8) * eta * (Rabs tau * md + mt + mt) <= (16 + / 8) * (u * / 2 ^ 102) *
    (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * Y + 2 * (6 * (2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * X))).
  { apply Rmult_le_compat; lra. }
  assert (0 <= u * X) by (apply Rmult_le_pos; lra). assert (0 <= u * Y) by (apply Rmult_le_pos; lra).
  set (uX := u * X) in *. set (uY := u * Y) in *.
  replace (9 * (u * (1 + / 2 ^ 16)) * (2 * (1 + / 2 ^ 17) * Y + 6 * (1 + / 2 ^ 17) * X))
    with (9 * (1 + / 2 ^ 16) * (1 + / 2 ^ 17) * (2 * uY + 6 * uX)) in E1 by (unfold uX, uY; ring).
  replace ((16 + / 8) * (u * / 2 ^ 102) *
    (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * Y + 2 * (6 * (2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * X)))
    with ((16 + / 8) * / 2 ^ 102 *
    (2 * (3 * 2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * uY + 2 * (6 * (2 ^ 20 + 2) * (2 ^ 34 + 2) ^ 2 * uX))) in E2 by (unfold uX, uY; ring).
  unfold FACTOR in *. lra.
Qed.

(** Of a ray whose line is certainly inside, with [s] the sign of the volumes: what is certainly in time, or out
    of it, is so. The ends are those that the code brings within [±LATEST], inwards. *)
Section Time.
Variables s tau t : R.
Hypothesis is_sign : s = 1 \/ s = -1.
Hypothesis has_sign : 0 < s * exact v det.
Hypothesis is_t : t * exact v det = exact v T.
Let row := mul_sub tau (s * computed det) (s * computed T).

Lemma row_is : s * (tau * exact v det - exact v T) = (tau - t) * (s * exact v det).
Proof. rewrite <- is_t. ring. Qed.

Theorem not_before : row <= - bound_at tau -> tau <= t.
Proof.
  intro H. pose proof (row_within_bound tau s is_sign) as E. rewrite row_is in E. apply Rabs_le_inv in E. fold row in E.
  apply Rnot_lt_le. intro L. assert (0 < (tau - t) * (s * exact v det)) by (apply Rmult_lt_0_compat; lra). lra.
Qed.
Theorem not_after : bound_at tau <= row -> t <= tau.
Proof.
  intro H. pose proof (row_within_bound tau s is_sign) as E. rewrite row_is in E. apply Rabs_le_inv in E. fold row in E.
  apply Rnot_lt_le. intro L. assert (0 < (t - tau) * (s * exact v det)) by (apply Rmult_lt_0_compat; lra). lra.
Qed.
Theorem before : bound_at tau < row -> t < tau.
Proof.
  intro H. pose proof (row_within_bound tau s is_sign) as E. rewrite row_is in E. apply Rabs_le_inv in E. fold row in E.
  apply Rnot_le_lt. intro L. assert (0 <= (t - tau) * (s * exact v det)) by (apply Rmult_le_pos; lra). lra.
Qed.
Theorem after : row < - bound_at tau -> tau < t.
Proof.
  intro H. pose proof (row_within_bound tau s is_sign) as E. rewrite row_is in E. apply Rabs_le_inv in E. fold row in E.
  apply Rnot_le_lt. intro L. assert (0 <= (tau - t) * (s * exact v det)) by (apply Rmult_le_pos; lra). lra.
Qed.
End Time.
End Filter.
