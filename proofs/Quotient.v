(** From numerators to values: what [MethodInfo::error_factor] claims, in multiples of [κ·u], where
    [κ = (P_N + |x|·P_det)/|det|] is the condition number of [x = N/det]. *)
Require Import Reals Lra Lia.
From Flocq Require Import Raux.
Require Import Trisect.Bound.
Open Scope R_scope.

Section Quotient.
Variables rnd : R -> R.
Variable u : R.
Hypothesis precise : 0 <= u <= / 2 ^ 24.
(** While nothing underflows. *)
Hypothesis rounds : forall x, Rabs (rnd x - x) <= u * Rabs x.
(** A numerator and a denominator, each within [k] roundings of its permanent, of at most ten. *)
Variables n n' p d d' q : R.
Variable k : R.
Hypothesis k_small : 1 <= k <= 10.
Hypothesis n_near : Rabs (n' - n) <= k * (u * (1 + / 2 ^ 16)) * p.
Hypothesis d_near : Rabs (d' - d) <= k * (u * (1 + / 2 ^ 16)) * q.
Hypothesis n_le : Rabs n <= p.
Hypothesis d_le : Rabs d <= q.
(** The denominator has a condition number up to 1600 in f32, where the claim starts. *)
Hypothesis clear : k * u * q <= / 1024 * Rabs d.
Hypothesis d_nonzero : d <> 0.

Let x := n / d.
Definition kappa := (p + Rabs x * q) / Rabs d.

Let D : 0 < Rabs d. Proof. apply Rabs_pos_lt. exact d_nonzero. Qed.

Lemma x_half : 2 * Rabs x <= kappa.
Proof.
  unfold kappa. apply Rmult_le_reg_r with (Rabs d); [exact D|].
  replace ((p + Rabs x * q) / Rabs d * Rabs d) with (p + Rabs x * q) by (field; lra).
  assert (Rabs x * Rabs d = Rabs n) by (rewrite <- Rabs_mult; unfold x; f_equal; field; exact d_nonzero).
  assert (Rabs x * Rabs d <= Rabs x * q) by (apply Rmult_le_compat_l; [apply Rabs_pos|exact d_le]). lra.
Qed.

Lemma d'_large : 2043 / 2048 * Rabs d <= Rabs d'.
Proof.
  assert (k * (u * (1 + / 2 ^ 16)) * q = (1 + / 2 ^ 16) * (k * u * q)) by ring.
  assert (Rabs d <= Rabs d' + Rabs (d' - d)).
  { replace d with (d' + - (d' - d)) at 1 by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  lra.
Qed.

Let D' : 0 < Rabs d'. Proof. pose proof d'_large. lra. Qed.
Let d'_nonzero : d' <> 0. Proof. intro E. rewrite E, Rabs_R0 in D'. lra. Qed.

(** The quotient of what is computed, before it is rounded. *)
Lemma quotient_near : Rabs (n' / d' - x) <= k * u * (1 + / 300) * kappa.
Proof.
  pose proof d'_large as L. pose proof (Rabs_pos x). pose proof (Rabs_pos n).
  assert (E : (n' / d' - x) * d' = (n' - n) - x * (d' - d)) by (unfold x; field; auto).
  apply Rmult_le_reg_r with (Rabs d'); [exact D'|]. rewrite <- Rabs_mult, E.
  unfold Rminus at 1. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp, Rabs_mult.
  assert (A : Rabs x * Rabs (d' - d) <= Rabs x * (k * (u * (1 + / 2 ^ 16)) * q)) by (apply Rmult_le_compat_l; lra).
  assert (K : kappa * Rabs d = p + Rabs x * q) by (unfold kappa; field; lra).
  assert (K0 : 0 <= kappa) by (pose proof x_half; lra).
  assert (KU : 0 <= k * u) by (apply Rmult_le_pos; lra).
  assert (B : k * u * (1 + / 300) * kappa * (2043 / 2048 * Rabs d) <= k * u * (1 + / 300) * kappa * Rabs d').
  { apply Rmult_le_compat_l; [|exact L]. apply Rmult_le_pos; [apply Rmult_le_pos; [exact KU|lra]|exact K0]. }
  replace (k * u * (1 + / 300) * kappa * (2043 / 2048 * Rabs d)) with ((1 + / 300) * (2043 / 2048) * (k * u * (kappa * Rabs d))) in B by field.
  rewrite K in B.
  assert (P : 0 <= k * u * (p + Rabs x * q)).
  { apply Rmult_le_pos; [exact KU|]. assert (0 <= Rabs x * q) by (apply Rmult_le_pos; lra). lra. }
  replace (Rabs x * (k * (u * (1 + / 2 ^ 16)) * q)) with ((1 + / 2 ^ 16) * (k * u * (Rabs x * q))) in A by ring.
  replace (k * (u * (1 + / 2 ^ 16)) * p) with ((1 + / 2 ^ 16) * (k * u * p)) in n_near by ring. lra.
Qed.

(** Divided, or multiplied by the rounded reciprocal: off by at most [(k + 1)·κ·u], to first order. *)
Theorem value_within (y : R) : y = rnd (n' / d') \/ y = rnd (n' * rnd (1 / d')) ->
  Rabs (y - x) <= (k + 1) * u * (1 + / 256) * kappa.
Proof.
  intro Y. pose proof quotient_near as N. pose proof x_half as H. pose proof (Rabs_pos x). set (z := n' / d') in *.
  assert (Z : Rabs z <= Rabs x + k * u * (1 + / 300) * kappa).
  { replace z with (x + (z - x)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  assert (KU : 0 <= k * u <= 10 * / 2 ^ 24) by (split; [apply Rmult_le_pos|apply Rmult_le_compat]; lra).
  assert (Z' : Rabs z <= (/ 2 + / 2 ^ 20) * kappa).
  { assert (k * u * (1 + / 300) * kappa <= 10 * / 2 ^ 24 * (1 + / 300) * kappa) by (apply Rmult_le_compat_r; [|apply Rmult_le_compat_r]; lra). lra. }
  assert (R : Rabs (y - z) <= (2 * u + u * u) * Rabs z).
  { pose proof (Rabs_pos z). destruct Y as [-> | ->].
    - pose proof (rounds z). assert (0 <= u * Rabs z) by (apply Rmult_le_pos; lra).
      assert (0 <= u * u * Rabs z) by (repeat apply Rmult_le_pos; lra). lra.
    - set (r := rnd (1 / d')). pose proof (rounds (1 / d')) as A. fold r in A. pose proof (rounds (n' * r)) as B.
      assert (C : Rabs (n' * r - z) <= u * Rabs z).
      { replace (n' * r - z) with (n' * (r - 1 / d')) by (unfold z; field; auto). rewrite Rabs_mult.
        replace (u * Rabs z) with (Rabs n' * (u * Rabs (1 / d'))).
        - apply Rmult_le_compat_l; [apply Rabs_pos|exact A].
        - unfold z, Rdiv. rewrite !Rabs_mult, Rabs_R1. ring. }
      assert (F : Rabs (n' * r) <= Rabs z + u * Rabs z).
      { replace (n' * r) with (z + (n' * r - z)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
      assert (u * Rabs (n' * r) <= u * (Rabs z + u * Rabs z)) by (apply Rmult_le_compat_l; lra).
      replace (rnd (n' * r) - z) with ((rnd (n' * r) - n' * r) + (n' * r - z)) by ring.
      eapply Rle_trans; [apply Rabs_triang|]. lra. }
  assert (S : (2 * u + u * u) * Rabs z <= (2 * u + u * u) * ((/ 2 + / 2 ^ 20) * kappa)).
  { apply Rmult_le_compat_l; [|exact Z']. assert (0 <= u * u) by (apply Rmult_le_pos; lra). lra. }
  assert (UU : u * u <= / 2 ^ 24 * u) by (apply Rmult_le_compat_r; lra).
  assert (S' : (2 * u + u * u) * ((/ 2 + / 2 ^ 20) * kappa) <= (2 * u + / 2 ^ 24 * u) * ((/ 2 + / 2 ^ 20) * kappa)).
  { apply Rmult_le_compat_r; lra. }
  replace (y - x) with ((y - z) + (z - x)) by ring. eapply Rle_trans; [apply Rabs_triang|].
  assert (0 <= u * kappa) by (apply Rmult_le_pos; lra).
  assert (0 <= k * u * kappa) by (apply Rmult_le_pos; lra). lra.
Qed.
End Quotient.
