(** The permanents of the exact kernel's volumes in norms, and what the signs of these volumes mean. *)
Require Import Reals Lra Lia.
Require Import Trisect.Bound Trisect.Methods.
Open Scope R_scope.

Notation det := exact_det.
Notation U := exact_beta.
Notation V := exact_gamma.
Notation W := exact_alpha.
Notation T := exact_t.

Section Norms.
Variable v : nat -> R.

(** [|D.x| + |D.y| + |D.z|] *)
Definition d1 := Rabs (v 3%nat) + Rabs (v 4%nat) + Rabs (v 5%nat).

(** [S] bounds the coordinates of [A − O], [h] those of the edges. *)
Record sized (S h : R) : Prop := {
  s0 : Rabs (v 6%nat - v 0%nat) <= S;
  s1 : Rabs (v 7%nat - v 1%nat) <= S;
  s2 : Rabs (v 8%nat - v 2%nat) <= S;
  b0 : Rabs (v 9%nat - v 6%nat) <= h;
  b1 : Rabs (v 10%nat - v 7%nat) <= h;
  b2 : Rabs (v 11%nat - v 8%nat) <= h;
  c0 : Rabs (v 12%nat - v 6%nat) <= h;
  c1 : Rabs (v 13%nat - v 7%nat) <= h;
  c2 : Rabs (v 14%nat - v 8%nat) <= h }.

Variables S h m : R.
Hypothesis is_sized : sized S h.
Hypothesis m_pos : 0 <= m.

Ltac differences :=
  destruct is_sized as [s0 s1 s2 b0 b1 b2 c0 c1 c2];
  assert (Rabs (v 6%nat - v 9%nat) <= h) by (rewrite Rabs_minus_sym; assumption);
  assert (Rabs (v 7%nat - v 10%nat) <= h) by (rewrite Rabs_minus_sym; assumption);
  assert (Rabs (v 8%nat - v 11%nat) <= h) by (rewrite Rabs_minus_sym; assumption).
Ltac positive := repeat first [apply Rabs_pos | exact m_pos | apply Rplus_le_le_0_compat | apply Rmult_le_pos].
(* Every magnitude of a difference gives way to its bound; those of the direction stay. *)
Ltac mono := match goal with
  | |- Rabs (_ - _) <= _ => eassumption
  | |- _ + _ <= _ => apply Rplus_le_compat; mono
  | |- _ * _ <= _ => apply Rmult_le_compat; [positive | positive | mono | mono]
  | |- _ => first [eassumption | apply Rle_refl] end.
Ltac norms e := differences; unfold e; eapply Rle_trans; [cbn [magnitude]; mono | unfold d1; apply Req_le; ring].

Theorem det_norm : magnitude v m det <= 2 * (d1 + 3 * m) * (h + m) ^ 2.
Proof. norms exact_det. Qed.
Theorem u_norm : magnitude v m U <= 2 * (d1 + 3 * m) * (S + m) * (h + m).
Proof. norms exact_beta. Qed.
Theorem v_norm : magnitude v m V <= 2 * (d1 + 3 * m) * (S + m) * (h + m).
Proof. norms exact_gamma. Qed.
Theorem t_norm : magnitude v m T <= 6 * (S + m) * (h + m) ^ 2.
Proof. norms exact_t. Qed.
Theorem w_norm : magnitude v m W <= 2 * (d1 + 3 * m) * (h + m) * ((h + m) + 2 * (S + m)).
Proof. norms exact_alpha. Qed.
End Norms.

(** The volumes are what the document says they are. *)
Section Meaning.
Variable v : nat -> R.
Notation O k := (v (0 + k)%nat). Notation D k := (v (3 + k)%nat). Notation A k := (v (6 + k)%nat).
Notation B k := (v (9 + k)%nat). Notation C k := (v (12 + k)%nat).
Notation x := (exact v).

Theorem sum_of_volumes : x det = x U + x V + x W.
Proof. cbv [exact_det exact_beta exact_gamma exact_alpha exact]. ring. Qed.

(** The point of the ray at [t] is the point of the triangle with the weights [beta] and [gamma]. *)
Definition meets t beta gamma := forall k, (k < 3)%nat ->
  O k + t * D k = A k + beta * (B k - A k) + gamma * (C k - A k).

(** Cramer's rule, and back. *)
Theorem meets_volumes t beta gamma : meets t beta gamma ->
  t * x det = x T /\ beta * x det = x U /\ gamma * x det = x V /\ (1 - beta - gamma) * x det = x W.
Proof.
  intro M. pose proof (M 0%nat ltac:(lia)) as X. pose proof (M 1%nat ltac:(lia)) as Y. pose proof (M 2%nat ltac:(lia)) as Z.
  cbn [Nat.add] in X, Y, Z.
  cbv [exact_det exact_beta exact_gamma exact_alpha exact_t exact].
  assert (X' : v 0%nat = v 6%nat + beta * (v 9%nat - v 6%nat) + gamma * (v 12%nat - v 6%nat) - t * v 3%nat) by lra.
  assert (Y' : v 1%nat = v 7%nat + beta * (v 10%nat - v 7%nat) + gamma * (v 13%nat - v 7%nat) - t * v 4%nat) by lra.
  assert (Z' : v 2%nat = v 8%nat + beta * (v 11%nat - v 8%nat) + gamma * (v 14%nat - v 8%nat) - t * v 5%nat) by lra.
  rewrite X', Y', Z'. repeat split; ring.
Qed.

Theorem volumes_meet : x det <> 0 -> meets (x T / x det) (x U / x det) (x V / x det).
Proof.
  intros N k K.
  apply (Rmult_eq_reg_r (x det)); [|assumption].
  replace ((O k + x T / x det * D k) * x det) with (O k * x det + x T * D k) by (field; assumption).
  replace ((A k + x U / x det * (B k - A k) + x V / x det * (C k - A k)) * x det)
    with (A k * x det + x U * (B k - A k) + x V * (C k - A k)) by (field; assumption).
  destruct k as [|[|[|]]]; [| | |lia]; cbn [Nat.add];
    cbv [exact_det exact_beta exact_gamma exact_alpha exact_t exact]; ring.
Qed.

(** The line of a ray that is not parallel meets the closed triangle just where the three volumes are all at
    least zero or all at most zero. *)
Theorem line_meets_triangle : x det <> 0 ->
  ((exists t beta gamma, meets t beta gamma /\ 0 <= beta /\ 0 <= gamma /\ beta + gamma <= 1) <->
   (0 <= x U /\ 0 <= x V /\ 0 <= x W) \/ (x U <= 0 /\ x V <= 0 /\ x W <= 0)).
Proof.
  intro N. split.
  - intros (t & beta & gamma & M & P & Q & R). destruct (meets_volumes _ _ _ M) as (_ & <- & <- & <-).
    destruct (Rle_lt_dec 0 (x det)); [left|right]; repeat split; nra.
  - intros H. exists (x T / x det), (x U / x det), (x V / x det). split; [apply volumes_meet; assumption|].
    pose proof sum_of_volumes as Sum.
    assert (E : x U / x det + x V / x det = 1 - x W / x det) by (field_simplify_eq; lra).
    assert (P : 0 <= x U / x det /\ 0 <= x V / x det /\ 0 <= x W / x det).
    { destruct H as [(a & b & c)|(a & b & c)].
      - assert (0 < / x det) by (apply Rinv_0_lt_compat; lra). repeat split; apply Rmult_le_pos; lra.
      - assert (/ x det < 0) by (apply Rinv_lt_0_compat; lra). unfold Rdiv.
        repeat split; rewrite <- Rmult_opp_opp; apply Rmult_le_pos; lra. }
    lra.
Qed.
End Meaning.
