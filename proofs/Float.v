(** What [Bound] supposes holds for f32 and f64, rounded to nearest with ties to even, by Flocq: with subnormal
    numbers, and where the processor flushes them to zero. Numbers that overflow are not considered here. *)
Require Import Reals Lra Psatz.
From Flocq Require Import Core Relative.
Open Scope R_scope.

(** Rounding to nearest where [eta] is the smallest normal number. *)
Record rounding (rnd : R -> R) (u eta : R) : Prop := {
  rounds : forall x, Rabs (rnd x - x) <= u * Rabs x + eta;
  rounds_normal : forall x, eta <= Rabs x -> Rabs (rnd x - x) <= u * Rabs x;
  rounds_sign : forall x, 0 <= x -> 0 <= rnd x }.
Definition reading (read : R -> R) eta := forall x, Rabs (read x - x) <= eta.

Section Format.
Variables emin prec : Z.
Context {positive : Prec_gt_0 prec}.
Hypothesis usual : (1 < prec)%Z.
Let fexp := FLT_exp emin prec.
Let u := / 2 * bpow radix2 (- prec + 1).
Let smallest := bpow radix2 (emin + prec - 1).

(** To nearest, ties to even, subnormal numbers included. *)
Definition nearest := round radix2 fexp ZnearestE.
(** Zero for what is subnormal. *)
Definition flush x := if Rlt_dec (Rabs x) smallest then 0 else x.

Lemma nearest_near x : Rabs (nearest x - x) <= u * Rabs x + / 2 * bpow radix2 emin.
Proof.
  unfold nearest, fexp, u.
  destruct (error_N_FLT radix2 emin prec positive (fun x => negb (Z.even x)) x) as (e & h & He & Hh & _ & E).
  rewrite E. replace (x * (1 + e) + h - x) with (e * x + h) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult.
  apply Rplus_le_compat; [apply Rmult_le_compat_r; [apply Rabs_pos|exact He]|exact Hh].
Qed.

Lemma half_le : / 2 * bpow radix2 emin <= smallest.
Proof.
  unfold smallest. assert (bpow radix2 emin <= bpow radix2 (emin + prec - 1)) by (apply bpow_le; lia).
  pose proof (bpow_gt_0 radix2 emin). lra.
Qed.

Lemma u_pos : 0 <= u.
Proof. unfold u. pose proof (bpow_ge_0 radix2 (- prec + 1)). lra. Qed.

Lemma nearest_pos x : 0 <= x -> 0 <= nearest x.
Proof.
  apply round_ge_generic; [apply FLT_exp_valid; exact positive|apply valid_rnd_N|apply generic_format_0].
Qed.

Lemma nearest_rounds : rounding nearest u smallest.
Proof.
  split; intros x.
  - pose proof (nearest_near x). pose proof half_le. lra.
  - intro N. apply relative_error_N_FLT; [exact positive|exact N].
  - apply nearest_pos.
Qed.

Lemma nearest_normal x : smallest <= Rabs x -> smallest <= Rabs (nearest x).
Proof.
  intro N. apply abs_round_ge_generic; [apply FLT_exp_valid; exact positive|apply valid_rnd_N| |exact N].
  apply generic_format_bpow. unfold fexp, FLT_exp, smallest. lia.
Qed.

Lemma flush_reads : reading flush smallest.
Proof.
  intro x. unfold flush. destruct (Rlt_dec (Rabs x) smallest) as [L|L].
  - replace (0 - x) with (- x) by ring. rewrite Rabs_Ropp. lra.
  - replace (x - x) with 0 by ring. rewrite Rabs_R0. unfold smallest. apply bpow_ge_0.
Qed.

Lemma flushed_rounds : rounding (fun x => flush (nearest x)) u smallest.
Proof.
  split; intros x; unfold flush at 1; destruct (Rlt_dec (Rabs (nearest x)) smallest) as [L|L].
  - replace (0 - x) with (- x) by ring. rewrite Rabs_Ropp.
    assert (Rabs x < smallest) by (apply Rnot_le_lt; intro G; apply nearest_normal in G; lra).
    pose proof u_pos. pose proof (Rabs_pos x). assert (0 <= u * Rabs x) by (apply Rmult_le_pos; lra). lra.
  - apply nearest_rounds.
  - intro N. apply nearest_normal in N. lra.
  - apply nearest_rounds.
  - lra.
  - apply nearest_pos.
Qed.
End Format.

Definition u32 := / 2 ^ 24.
Definition u64 := / 2 ^ 53.
(** The smallest normal numbers. *)
Definition eta32 := / 2 ^ 126.
Definition eta64 := / 2 ^ 1022.

Definition f32 := nearest (-149) 24.
Definition f64 := nearest (-1074) 53.
Definition flush32 := flush (-149) 24.
Definition flush64 := flush (-1074) 53.
(** With subnormal numbers flushed to zero. *)
Definition f32_flushed x := flush32 (f32 x).
Definition f64_flushed x := flush64 (f64 x).

Lemma bpow_neg n : bpow radix2 (- Z.of_nat n) = / 2 ^ n.
Proof. rewrite bpow_opp, bpow_powerRZ, pow_powerRZ. reflexivity. Qed.

Lemma half_bpow n : / 2 * bpow radix2 (- Z.of_nat (S n) + 1) = / 2 ^ S n.
Proof.
  replace (- Z.of_nat (S n) + 1)%Z with (- Z.of_nat n)%Z by lia.
  rewrite bpow_neg. cbn [pow]. rewrite Rinv_mult. reflexivity.
Qed.

Local Instance p24 : Prec_gt_0 24. Proof. reflexivity. Qed.
Local Instance p53 : Prec_gt_0 53. Proof. reflexivity. Qed.

(** Subnormal numbers that are not flushed take less. *)
Theorem f32_rounds_finely x : Rabs (f32 x - x) <= u32 * Rabs x + u32 * eta32.
Proof.
  pose proof (nearest_near (-149) 24 x) as N. fold f32 in N.
  replace (u32 * eta32) with (/ 2 * bpow radix2 (-149)).
  - unfold u32. rewrite <- (half_bpow 23). exact N.
  - change (-149)%Z with (- Z.of_nat 149)%Z. rewrite bpow_neg. unfold u32, eta32. lra.
Qed.
Theorem f32_rounds : rounding f32 u32 eta32.
Proof.
  unfold u32, eta32. rewrite <- (half_bpow 23), <- (bpow_neg 126).
  apply (nearest_rounds (-149) 24). lia.
Qed.
Theorem f32_flushed_rounds : rounding f32_flushed u32 eta32.
Proof.
  unfold u32, eta32. rewrite <- (half_bpow 23), <- (bpow_neg 126).
  apply (flushed_rounds (-149) 24). lia.
Qed.
Theorem flush32_reads : reading flush32 eta32.
Proof. unfold eta32. rewrite <- (bpow_neg 126). apply (flush_reads (-149) 24). Qed.

Theorem f64_rounds : rounding f64 u64 eta64.
Proof.
  unfold u64, eta64. rewrite <- (half_bpow 52), <- (bpow_neg 1022).
  apply (nearest_rounds (-1074) 53). lia.
Qed.
Theorem f64_flushed_rounds : rounding f64_flushed u64 eta64.
Proof.
  unfold u64, eta64. rewrite <- (half_bpow 52), <- (bpow_neg 1022).
  apply (flushed_rounds (-1074) 53). lia.
Qed.
Theorem flush64_reads : reading flush64 eta64.
Proof. unfold eta64. rewrite <- (bpow_neg 1022). apply (flush_reads (-1074) 53). Qed.

(** The arithmetics that kernels run in: how they round, how they read numbers, [u], and the smallest normal number. *)
Inductive machine : (R -> R) -> (R -> R) -> R -> R -> Prop :=
| single : machine f32 (fun x => x) u32 eta32
| single_flushed : machine f32_flushed flush32 u32 eta32
| double : machine f64 (fun x => x) u64 eta64
| double_flushed : machine f64_flushed flush64 u64 eta64.

Theorem machine_rounds rnd read u eta : machine rnd read u eta -> rounding rnd u eta.
Proof. intros []; [apply f32_rounds|apply f32_flushed_rounds|apply f64_rounds|apply f64_flushed_rounds]. Qed.
Theorem machine_reads rnd read u eta : machine rnd read u eta -> reading read eta.
Proof.
  intros []; [| apply flush32_reads | | apply flush64_reads]; intro x; replace (x - x) with 0 by ring; rewrite Rabs_R0;
    unfold eta32, eta64; left; apply Rinv_0_lt_compat, pow_lt; lra.
Qed.
Theorem machine_is_fine rnd read u eta : machine rnd read u eta -> 0 < u <= / 2 ^ 24 /\ 0 <= eta <= u * / 2 ^ 102.
Proof. intros []; unfold u32, u64, eta32, eta64; lra. Qed.
Theorem machine_limits rnd read u eta : machine rnd read u eta -> / 2 ^ 53 <= u /\ 0 < eta.
Proof. intros []; unfold u32, u64, eta32, eta64; (split; [lra|apply Rinv_0_lt_compat, pow_lt; lra]). Qed.
