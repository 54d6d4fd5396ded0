(** The claim behind [error_factor: 9] of those methods whose numerators have the permanents that the condition number
    is made of: Möller–Trumbore in all orders, Kensler–Shirley in all forms. *)
Require Import List Reals Lra Lia.
Import ListNotations.
Require Import Trisect.Bound Trisect.Methods Trisect.Double Trisect.Quotient.
Open Scope R_scope.

(** [det], [t], [beta], [gamma] of each. *)
Definition nine : list (expr * expr * expr * expr) :=
  [(moller_trumbore_det, moller_trumbore_t, moller_trumbore_beta, moller_trumbore_gamma);
   (moller_trumbore_1_det, moller_trumbore_1_t, moller_trumbore_1_beta, moller_trumbore_1_gamma);
   (moller_trumbore_2_det, moller_trumbore_2_t, moller_trumbore_2_beta, moller_trumbore_2_gamma);
   (moller_trumbore_3_det, moller_trumbore_3_t, moller_trumbore_3_beta, moller_trumbore_3_gamma);
   (moller_trumbore_4_det, moller_trumbore_4_t, moller_trumbore_4_beta, moller_trumbore_4_gamma);
   (kensler_shirley_det, kensler_shirley_t, kensler_shirley_beta, kensler_shirley_gamma);
   (kensler_shirley_points_det, kensler_shirley_points_t, kensler_shirley_points_beta, kensler_shirley_points_gamma);
   (kensler_shirley_normal_det, kensler_shirley_normal_t, kensler_shirley_normal_beta, kensler_shirley_normal_gamma);
   (kensler_shirley_stored_det, kensler_shirley_stored_t, kensler_shirley_stored_beta, kensler_shirley_stored_gamma)].

(** The same value, the same permanent, and at most [k] roundings. *)
Definition like v (k : nat) e e' := exact v e = exact v e' /\ perm v e = perm v e' /\ (depth e <= k)%nat.
Definition turned v (k : nat) e e' := exact v e = - exact v e' /\ perm v e = perm v e' /\ (depth e <= k)%nat.

Ltac one_way v := rewrite ?(Rabs_minus_sym (v 6%nat) (v 0%nat)), ?(Rabs_minus_sym (v 7%nat) (v 1%nat)), ?(Rabs_minus_sym (v 8%nat) (v 2%nat)),
  ?(Rabs_minus_sym (v 6%nat) (v 9%nat)), ?(Rabs_minus_sym (v 7%nat) (v 10%nat)), ?(Rabs_minus_sym (v 8%nat) (v 11%nat)),
  ?(Rabs_minus_sym (v 6%nat) (v 12%nat)), ?(Rabs_minus_sym (v 7%nat) (v 13%nat)), ?(Rabs_minus_sym (v 8%nat) (v 14%nat)).
Ltac compare v := split; [cbn [exact]; ring|split; [unfold perm; cbn [magnitude]; one_way v; ring|apply PeanoNat.Nat.leb_le; reflexivity]].

(** The numerators are the condition number's own, all with the same sign. *)
Theorem same_permanents v : Forall (fun '(d, t, b, g) =>
  (like v 8 d det /\ like v 8 t T /\ like v 8 b U /\ like v 8 g V) \/
  (turned v 8 d det /\ turned v 8 t T /\ turned v 8 b U /\ turned v 8 g V)) nine.
Proof.
  unfold nine. repeat apply Forall_cons; try apply Forall_nil.
  all: cbv beta delta -[exact perm depth magnitude Rplus Rmult Rminus Ropp Rabs like turned IZR Nat.leb].
  all: first [left; split; [|split; [|split]]; unfold like; compare v | right; split; [|split; [|split]]; unfold turned; compare v].
Qed.

Section Claim.
Variable rnd : R -> R.
Variable u : R.
Hypothesis precise : 0 <= u <= / 2 ^ 24.
(** While nothing underflows. *)
Hypothesis rounds : forall x, Rabs (rnd x - x) <= u * Rabs x.
Variable fuse : bool.
Variable v : nat -> R.
Definition computed e := float rnd v (if fuse then fused e else e).

Lemma numerator e : (depth e <= 8)%nat -> Rabs (computed e - exact v e) <= 8 * (u * (1 + / 2 ^ 16)) * perm v e.
Proof.
  intro K. unfold computed. set (e' := if fuse then fused e else e).
  assert (E : exact v e' = exact v e /\ perm v e' = perm v e /\ (depth e' <= 8)%nat).
  { unfold e', perm, fused. destruct fuse; [|auto]. pose proof (depth_fused (fun _ => false) e). rewrite exact_fused, magnitude_fused. repeat split. lia. }
  destruct E as (<- & <- & D).
  assert (R : forall x, Rabs (rnd x - x) <= u * Rabs x + 0) by (intro x; pose proof (rounds x); lra).
  assert (I : forall i, Rabs (v i - v i) <= 0) by (intro i; replace (v i - v i) with 0 by ring; rewrite Rabs_R0; lra).
  destruct (bounded rnd u 0 (proj1 precise) (Rle_refl 0) R v v I 1 (Rle_refl 1) e') as [N _].
  replace (lost 0 1) with 0 in N by (unfold lost; field). replace ((1 + 0) ^ losses e') with 1 in N by (rewrite Rplus_0_r, pow1; reflexivity).
  pose proof (pow_le u 8 precise ltac:(lia)) as P. replace (INR 8) with 8 in P by (simpl; lra).
  assert ((1 + u) ^ depth e' <= (1 + u) ^ 8) by (apply Rle_pow; [lra|exact D]).
  assert (0 <= perm v e') by (apply magnitude_pos; lra).
  assert (((1 + u) ^ depth e' - 1) * perm v e' <= 8 * (u * (1 + / 2 ^ 16)) * perm v e') by (apply Rmult_le_compat_r; lra). lra.
Qed.

Lemma magnitude_le e : Rabs (exact v e) <= perm v e.
Proof.
  assert (I : forall i, Rabs (v i - v i) <= 0) by (intro i; replace (v i - v i) with 0 by ring; rewrite Rabs_R0; lra).
  assert (R : forall x, Rabs (x - x) <= 0 * Rabs x + 0) by (intro x; replace (x - x) with 0 by ring; rewrite Rabs_R0; lra).
  destruct (bounded (fun x => x) 0 0 (Rle_refl 0) (Rle_refl 0) R v v I 1 (Rle_refl 1) e) as [_ [P _]]. exact P.
Qed.

(** [t], [beta] or [gamma] of a pair whose [det] is well conditioned, divided or multiplied by the rounded reciprocal of
    [det]: off by at most [9·κ·u], to first order. *)
Theorem error_factor_is_9 d t b g e e' y : List.In (d, t, b, g) nine -> List.In (e, e') [(t, T); (b, U); (g, V)] ->
  exact v det <> 0 -> 8 * u * perm v det <= / 1024 * Rabs (exact v det) ->
  y = rnd (computed e / computed d) \/ y = rnd (computed e * rnd (1 / computed d)) ->
  let x := exact v e' / exact v det in
  Rabs (y - x) <= 9 * u * (1 + / 256) * ((perm v e' + Rabs x * perm v det) / Rabs (exact v det)).
Proof.
  intros I J N C Y x. pose proof (same_permanents v) as A. rewrite Forall_forall in A. specialize (A _ I). cbv beta iota in A.
  assert (B : (like v 8 d det /\ like v 8 e e') \/ (turned v 8 d det /\ turned v 8 e e')).
  { destruct A as [(D & A1 & A2 & A3)|(D & A1 & A2 & A3)]; [left|right]; (split; [exact D|]);
      destruct J as [J|[J|[J|[]]]]; injection J as <- <-; assumption. }
  assert (F : exact v d <> 0 /\ exact v e / exact v d = x /\ perm v e = perm v e' /\ perm v d = perm v det /\
    Rabs (exact v d) = Rabs (exact v det) /\ (depth d <= 8)%nat /\ (depth e <= 8)%nat).
  { unfold x. destruct B as [((D1 & D2 & D3) & (E1 & E2 & E3))|((D1 & D2 & D3) & (E1 & E2 & E3))]; rewrite D1, E1.
    - repeat split; assumption || reflexivity.
    - repeat split; try assumption; [lra|field; exact N|apply Rabs_Ropp]. }
  destruct F as (Nd & X & P1 & P2 & Q & K1 & K2). rewrite <- X, <- P1, <- P2, <- Q. rewrite <- P2, <- Q in C.
  replace 9 with (8 + 1) by ring.
  exact (value_within rnd u precise rounds _ _ _ _ _ _ 8 ltac:(lra) (numerator e K2) (numerator d K1) (magnitude_le e) (magnitude_le d) C Nd y Y).
Qed.
End Claim.
