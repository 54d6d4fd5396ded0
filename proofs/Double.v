(** The second stage of the exact kernel: one pair in f64, each number with a bound of its own error by its
    permanent. Names are those of crates/methods/exact/src/double.rs. *)
Require Import List Reals Lra Lia Psatz.
Import ListNotations.
From Flocq Require Import Raux.
Require Import Trisect.Bound Trisect.Float Trisect.Norms.
Open Scope R_scope.

(** The constants of the code. *)
Definition LARGEST := 2 ^ 130.
Definition UNDERFLOW := / 2 ^ 620.
Definition UNIT := 10 * / 2 ^ 53.

(** The volumes: [s = O − A], [p = D × E2], [q = S × E1]. *)
Definition vector := (expr * expr * expr)%type.
Definition cross (a b : vector) : vector := let '(a1, a2, a3) := a in let '(b1, b2, b3) := b in
  (MulSub a2 b3 (Mul a3 b2), MulSub a3 b1 (Mul a1 b3), MulSub a1 b2 (Mul a2 b1)).
Definition dot (a b : vector) := let '(a1, a2, a3) := a in let '(b1, b2, b3) := b in
  MulAdd a1 b1 (MulAdd a2 b2 (Mul a3 b3)).
Definition s : vector := (Diff 0 6, Diff 1 7, Diff 2 8).
Definition d : vector := (In 3, In 4, In 5).
Definition e1 : vector := (Diff 9 6, Diff 10 7, Diff 11 8).
Definition e2 : vector := (Diff 12 6, Diff 13 7, Diff 14 8).
Definition det := Eval compute in dot e1 (cross d e2).
Definition U := Eval compute in dot s (cross d e2).
Definition V := Eval compute in dot d (cross s e1).
Definition T := Eval compute in dot e2 (cross s e1).
Definition W := Eval compute in Sub (Sub det U) V.

(** They are those of the filter. *)
Theorem same_volumes v : exact v det = exact v Norms.det /\ exact v U = exact v Norms.U /\ exact v V = exact v Norms.V
  /\ exact v W = exact v Norms.W /\ exact v T = exact v Norms.T.
Proof.
  cbv [det U V W T exact Methods.exact_det Methods.exact_beta Methods.exact_gamma Methods.exact_alpha Methods.exact_t].
  repeat split; ring.
Qed.

Section Double.
Variable rnd : R -> R.
Variable eta : R.
Hypothesis arithmetic : rounding rnd u64 eta.
Hypothesis wide : 0 <= eta <= eta64.
Variables v f : nat -> R.
Hypothesis reads : forall i, Rabs (f i - v i) <= eta.

Definition difference i j := rnd (f i - f j).
Definition pairs := [(0, 6); (1, 7); (2, 8); (9, 6); (10, 7); (11, 8); (12, 6); (13, 7); (14, 8)]%nat.
(** The pair is in range. *)
Hypothesis differences_small : forall i j, List.In (i, j) pairs -> Rabs (difference i j) <= LARGEST.
Hypothesis direction_small : forall i, List.In i [3; 4; 5]%nat -> Rabs (f i) <= LARGEST.

Let u := u64.
Let u_pos : 0 <= u. Proof. unfold u, u64. lra. Qed.
Let eta_pos : 0 <= eta. Proof. lra. Qed.
Let m_ge : 1 <= LARGEST. Proof. unfold LARGEST. lra. Qed.
Let rounded := rounds _ _ _ arithmetic.
Let near := near u eta LARGEST.
Let M := 2 ^ 390.

(** [Estimate::bounded] *)
Definition error p := rnd (rnd (UNIT * p) + UNDERFLOW).

Lemma lost_le : lost eta LARGEST <= / 2 ^ 1152.
Proof.
  unfold lost, LARGEST. apply Rle_trans with (/ 2 ^ 1022 / 2 ^ 130); [|lra].
  apply Rmult_le_compat_r; unfold eta64 in wide; lra.
Qed.

(** A number and its permanent, both as computed: the error is within the bound. *)
Lemma within x x' p p' q : near x x' p q 9 16 -> near p p' p q 9 16 -> q <= 60 * (LARGEST * M) ->
  Rabs (x' - x) <= error p'.
Proof.
  intros X P Q. pose proof lost_le as L. assert (L0 : 0 <= lost eta LARGEST) by (apply lost_pos; assumption).
  assert (P0 : 0 <= p) by (destruct X as [_ [A _]]; pose proof (Rabs_pos x); lra).
  assert (Q0 : 0 <= q) by (destruct X as [_ [_ A]]; lra).
  unfold near in *.
  pose proof (near_within u eta u_pos eta_pos LARGEST m_ge _ _ _ _ _ _ X ltac:(unfold u, u64; lra) ltac:(lra) ltac:(lia) ltac:(lia)) as E.
  pose proof (near_within u eta u_pos eta_pos LARGEST m_ge _ _ _ _ _ _ P ltac:(unfold u, u64; lra) ltac:(lra) ltac:(lia) ltac:(lia)) as F.
  replace (INR 9) with 9 in * by (simpl; lra). replace (INR 16) with 16 in * by (simpl; lra).
  assert (G : (16 + / 8) * lost eta LARGEST * q <= (16 + / 8) * / 2 ^ 1152 * (60 * (LARGEST * M))) by (apply Rmult_le_compat; lra).
  set (lo := (16 + / 8) * lost eta LARGEST * q) in *. assert (H : lo <= / 3 * UNDERFLOW).
  { eapply Rle_trans; [exact G|]. unfold LARGEST, M, UNDERFLOW. lra. }
  apply Rabs_le_inv in F. unfold u, u64 in *.
  assert (Eta : eta <= / 2 ^ 200 * UNDERFLOW) by (unfold eta64, UNDERFLOW in *; lra).
  assert (0 < UNDERFLOW) by (unfold UNDERFLOW; lra).
  pose proof (rounded (UNIT * p')) as A. unfold u64 in A.
  assert (B : Rabs (UNIT * p') <= UNIT * p' + UNDERFLOW) by (unfold Rabs; destruct (Rcase_abs _); unfold UNIT in *; lra).
  apply Rabs_le_inv in A.
  set (y := rnd (UNIT * p')) in *.
  assert (Y : UNIT * p' * (1 - / 2 ^ 53) - / 2 ^ 52 * UNDERFLOW <= y) by lra.
  pose proof (rounded (y + UNDERFLOW)) as C. unfold u64 in C.
  assert (Z : 0 <= y + UNDERFLOW) by (unfold UNIT in *; lra).
  rewrite (Rabs_right (y + UNDERFLOW)) in C by lra. apply Rabs_le_inv in C.
  unfold error. fold y. unfold UNIT in *. lra.
Qed.

Lemma value e : Bound.near u eta LARGEST (exact v e) (float rnd f e) (perm v e) (magnitude v LARGEST e) (depth e) (losses e).
Proof. apply bounded; assumption. Qed.
Lemma value_perm e : Bound.near u eta LARGEST (perm v e) (float_perm rnd f e) (perm v e) (magnitude v LARGEST e) (depth e) (losses e).
Proof. apply perm_bounded; assumption. Qed.

(** What a coordinate may be, at most. *)
Let r := (2 + / 2 ^ 20) * LARGEST.
Lemma small i j : List.In (i, j) pairs -> Rabs (v i - v j) + LARGEST <= r.
Proof.
  intro I. pose proof (differences_small i j I) as D. unfold difference in D. pose proof (rounded (f i - f j)) as N.
  pose proof (reads i). pose proof (reads j). unfold u64, eta64 in *.
  assert (Rabs (v i - v j) <= Rabs (f i - f j) + 2 * eta).
  { replace (v i - v j) with ((f i - f j) + (- (f i - v i) + (f j - v j))) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat_l.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  assert (Rabs (f i - f j) <= Rabs (rnd (f i - f j)) + (/ 2 ^ 53 * Rabs (f i - f j) + eta)).
  { set (x := f i - f j) in *. replace x with (rnd x + - (rnd x - x)) at 1 by ring.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  unfold r, LARGEST in *. lra.
Qed.
Lemma small' i j : List.In (j, i) pairs -> Rabs (v i - v j) + LARGEST <= r.
Proof. intro. rewrite Rabs_minus_sym. apply small. assumption. Qed.
Lemma small_d i : List.In i [3; 4; 5]%nat -> Rabs (v i) + LARGEST <= r.
Proof.
  intro I. pose proof (direction_small i I). pose proof (reads i).
  assert (Rabs (v i) <= Rabs (f i) + eta).
  { replace (v i) with (f i + - (f i - v i)) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. lra. }
  unfold r, LARGEST, eta64 in *. lra.
Qed.

Ltac positive := repeat first [apply Rabs_pos | exact (Rlt_le _ _ (pow_lt 2 130 Rlt_0_2)) | apply Rplus_le_le_0_compat | apply Rmult_le_pos].
Ltac mono := match goal with
  | |- Rabs (_ - _) + _ <= _ => first [apply small; cbv; tauto | apply small'; cbv; tauto]
  | |- Rabs _ + _ <= _ => apply small_d; cbv; tauto
  | |- _ + _ <= _ => apply Rplus_le_compat; mono
  | |- _ * _ <= _ => apply Rmult_le_compat; [positive | positive | mono | mono] end.
Lemma det_size : magnitude v LARGEST det <= 6 * (r * r * r).
Proof. eapply Rle_trans; [cbv [det]; cbn [magnitude]; mono|apply Req_le; ring]. Qed.
Lemma w_size : magnitude v LARGEST W <= 18 * (r * r * r).
Proof. eapply Rle_trans; [cbv [W]; cbn [magnitude]; mono|apply Req_le; ring]. Qed.
Lemma t_size : magnitude v LARGEST T <= 6 * (r * r * r).
Proof. eapply Rle_trans; [cbv [T]; cbn [magnitude]; mono|apply Req_le; ring]. Qed.

Lemma r_cubed : r * r * r <= (9 * M).
Proof. unfold r, M, LARGEST. lra. Qed.

Lemma small_volume e : List.In e [det; U; V; W; T] -> magnitude v LARGEST e <= 60 * (LARGEST * M) /\ (depth e <= 9)%nat /\ (losses e <= 16)%nat.
Proof.
  assert (P : forall e, 0 <= magnitude v LARGEST e) by (intro; apply magnitude_pos; unfold LARGEST; lra).
  assert (D : magnitude v LARGEST W = magnitude v LARGEST det + magnitude v LARGEST U + magnitude v LARGEST V) by reflexivity.
  pose proof w_size. pose proof t_size. pose proof r_cubed. pose proof (P det). pose proof (P U). pose proof (P V).
  assert (18 * (9 * M) <= 60 * (LARGEST * M)) by (unfold LARGEST, M; lra).
  intros [<-|[<-|[<-|[<-|[<-|[]]]]]]; (split; [lra|]); split; apply PeanoNat.Nat.leb_le; reflexivity.
Qed.

Lemma deepen x x' p q k l : (k <= 9)%nat -> (l <= 16)%nat -> Bound.near u eta LARGEST x x' p q k l -> near x x' p q 9 16.
Proof. intros K L N. eapply near_weaken; [exact u_pos|exact eta_pos|exact m_ge|exact K|exact L|exact N]. Qed.

(** [det], [U], [V], [W] and [T] are off by no more than the bound that is computed from their permanents. *)
Theorem volumes_within_error e : List.In e [det; U; V; W; T] ->
  Rabs (float rnd f e - exact v e) <= error (float_perm rnd f e).
Proof.
  intro I. destruct (small_volume e I) as (A & B & C).
  exact (within _ _ _ _ _ (deepen _ _ _ _ _ _ B C (value e)) (deepen _ _ _ _ _ _ B C (value_perm e)) A).
Qed.

(** So is [T − τ·det], with the signs turned or not. *)
Theorem row_within_error tau sign : Rabs tau <= LARGEST -> sign = 1 \/ sign = -1 ->
  Rabs (rnd (sign * float rnd f T - rnd (tau * (sign * float rnd f det))) - sign * (exact v T - tau * exact v det))
  <= error (rnd (float_perm rnd f T + rnd (Rabs tau * float_perm rnd f det))).
Proof.
  intros Tau Hs. pose proof (Rabs_pos tau) as T0.
  assert (L : LARGEST <= magnitude v LARGEST T) by (apply large; exact m_ge).
  assert (L' : 0 <= magnitude v LARGEST det) by (apply magnitude_pos; unfold LARGEST; lra).
  pose proof det_size as Sd. pose proof t_size as St. pose proof r_cubed as R3.
  set (md := magnitude v LARGEST det) in *. set (mt := magnitude v LARGEST T) in *.
  set (pd := perm v det) in *. set (pt := perm v T) in *.
  assert (D : near (sign * exact v det) (sign * float rnd f det) pd md 7 13).
  { eapply near_weaken; [exact u_pos|exact eta_pos|exact m_ge| | |apply near_sign; [exact Hs|exact (value det)]]; apply PeanoNat.Nat.leb_le; reflexivity. }
  assert (Dp : near pd (float_perm rnd f det) pd md 7 13).
  { eapply near_weaken; [exact u_pos|exact eta_pos|exact m_ge| | |exact (value_perm det)]; apply PeanoNat.Nat.leb_le; reflexivity. }
  assert (N : near (sign * exact v T) (sign * float rnd f T) pt mt 8 15).
  { eapply near_weaken; [exact u_pos|exact eta_pos|exact m_ge| | |apply near_sign; [exact Hs|exact (value T)]]; apply PeanoNat.Nat.leb_le; reflexivity. }
  assert (Np : near pt (float_perm rnd f T) pt mt 8 15).
  { eapply near_weaken; [exact u_pos|exact eta_pos|exact m_ge| | |exact (value_perm T)]; apply PeanoNat.Nat.leb_le; reflexivity. }
  assert (D0 : forall w, Rabs w = Rabs tau -> near w w (Rabs tau) (Rabs tau) 0 0) by (intros w E; apply near_refl; lra).
  assert (L2 : LARGEST <= Rabs tau * md + mt).
  { assert (0 <= Rabs tau * md) by (apply Rmult_le_pos; assumption). lra. }
  assert (Product : forall w y y', Rabs w = Rabs tau -> near y y' pd md 7 13 ->
    near (w * y) (rnd (w * y')) (Rabs tau * pd) (Rabs tau * md + mt) 8 15).
  { intros w y y' E Y. pose proof (near_mul u eta u_pos eta_pos LARGEST m_ge _ _ _ _ _ _ _ _ _ _ _ _ (D0 w E) Y) as X.
    apply (near_more u eta u_pos eta_pos LARGEST m_ge) with (q' := Rabs tau * md + mt) in X; [|lra].
    apply (near_rnd rnd u eta u_pos eta_pos rounded LARGEST m_ge) in X; [|exact L2].
    eapply near_weaken; [exact u_pos|exact eta_pos|exact m_ge| | |exact X]; lia. }
  apply within with (p := pt + Rabs tau * pd) (q := mt + (Rabs tau * md + mt)).
  - replace (sign * (exact v T - tau * exact v det)) with (sign * exact v T - tau * (sign * exact v det)) by ring.
    apply near_rnd; try assumption; try exact m_ge; [lra|]. apply near_sub; [exact N|]. apply Product; [reflexivity|exact D].
  - apply near_rnd; try assumption; try exact m_ge; [lra|]. apply near_add; [exact Np|].
    apply Product; [apply Rabs_Rabsolu|exact Dp].
  - assert (Rabs tau * md <= LARGEST * (6 * (9 * M))) by (apply Rmult_le_compat; lra).
    assert (12 * (9 * M) <= LARGEST * M) by (unfold LARGEST, M; lra). lra.
Qed.

(** A sign that is certain is the sign of the exact number. *)
Theorem certain_sign x x' e : Rabs (x' - x) <= e -> (e < x' -> 0 < x) /\ (x' < - e -> x < 0).
Proof. intro H. apply Rabs_le_inv in H. lra. Qed.
End Double.
