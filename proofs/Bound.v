(** How far rounding, underflow included, takes any formula of sums and products from its exact value: by
    induction over the formula, for any rounding that keeps the one hypothesis [rounds]. *)
Require Import Reals Lra Lia.
Open Scope R_scope.

(** A formula over numbered inputs. *)
Inductive expr :=
| In (i : nat)
| Diff (i j : nat)                                 (* of two inputs, rounded once *)
| Neg (a : expr)
| Add (a b : expr) | Sub (a b : expr) | Mul (a b : expr)
| MulAdd (a b c : expr) | MulSub (a b c : expr)    (* a·b ± c, rounded twice *)
| Fma (a b c : expr) | Fms (a b c : expr).         (* the same, rounded once *)

(** The formula where multiply-add is fused, but in what [keep] picks. *)
Fixpoint fused_but (keep : expr -> bool) e := if keep e then e else match e with
| In i => In i | Diff i j => Diff i j | Neg a => Neg (fused_but keep a)
| Add a b => Add (fused_but keep a) (fused_but keep b)
| Sub a b => Sub (fused_but keep a) (fused_but keep b)
| Mul a b => Mul (fused_but keep a) (fused_but keep b)
| MulAdd a b c | Fma a b c => Fma (fused_but keep a) (fused_but keep b) (fused_but keep c)
| MulSub a b c | Fms a b c => Fms (fused_but keep a) (fused_but keep b) (fused_but keep c) end.
Definition fused := fused_but (fun _ => false).

(** Whether two formulas are the same. *)
Fixpoint same a b := match a, b with
| In i, In j => Nat.eqb i j
| Diff i j, Diff k l => Nat.eqb i k && Nat.eqb j l
| Neg a, Neg b => same a b
| Add a b, Add c d | Sub a b, Sub c d | Mul a b, Mul c d => same a c && same b d
| MulAdd a b c, MulAdd d e f | MulSub a b c, MulSub d e f | Fma a b c, Fma d e f | Fms a b c, Fms d e f =>
  same a d && same b e && same c f
| _, _ => false end%bool.

(** How many roundings a term of the formula goes through at most. *)
Fixpoint depth e : nat := match e with
| In _ => 0 | Diff _ _ => 1 | Neg a => depth a
| Add a b | Sub a b => S (Nat.max (depth a) (depth b))
| Mul a b => S (depth a + depth b)
| MulAdd a b c | MulSub a b c => S (Nat.max (S (depth a + depth b)) (depth c))
| Fma a b c | Fms a b c => S (Nat.max (depth a + depth b) (depth c)) end.

(** How many times a term may lose the size of a subnormal number: in each rounding and in each input. *)
Fixpoint losses e : nat := match e with
| In _ => 1 | Diff _ _ => 3 | Neg a => losses a
| Add a b | Sub a b => S (Nat.max (losses a) (losses b))
| Mul a b => S (losses a + losses b)
| MulAdd a b c | MulSub a b c => S (Nat.max (S (losses a + losses b)) (losses c))
| Fma a b c | Fms a b c => S (Nat.max (losses a + losses b) (losses c)) end.

Section Values.
Variable v : nat -> R.

(** The exact value. *)
Fixpoint exact e := match e with
| In i => v i | Diff i j => v i - v j | Neg a => - exact a
| Add a b => exact a + exact b | Sub a b => exact a - exact b | Mul a b => exact a * exact b
| MulAdd a b c | Fma a b c => exact a * exact b + exact c
| MulSub a b c | Fms a b c => exact a * exact b - exact c end.

(** The formula with [m] and magnitudes for numbers and sums for differences. *)
Fixpoint magnitude (m : R) e := match e with
| In i => Rabs (v i) + m | Diff i j => Rabs (v i - v j) + m | Neg a => magnitude m a
| Add a b | Sub a b => magnitude m a + magnitude m b
| Mul a b => magnitude m a * magnitude m b
| MulAdd a b c | MulSub a b c | Fma a b c | Fms a b c => magnitude m a * magnitude m b + magnitude m c end.

(** The permanent: the sum of the magnitudes of all terms. *)
Definition perm := magnitude 0.

Lemma magnitude_pos m e : 0 <= m -> 0 <= magnitude m e.
Proof.
  intro H. induction e; simpl;
    try (pose proof (Rabs_pos (v i)); lra); try (pose proof (Rabs_pos (v i - v j)); lra); try lra;
    try (apply Rplus_le_le_0_compat); try (apply Rmult_le_pos); assumption.
Qed.

Lemma magnitude_ge m e : 1 <= m -> m <= magnitude m e.
Proof.
  intro H. induction e; simpl;
    try (pose proof (Rabs_pos (v i)); lra); try (pose proof (Rabs_pos (v i - v j)); lra); try lra;
    assert (m * 1 <= magnitude m e1 * magnitude m e2) by (apply Rmult_le_compat; lra); lra.
Qed.

Lemma magnitude_mono m n e : 0 <= m <= n -> magnitude m e <= magnitude n e.
Proof.
  intro H. assert (P : forall e, 0 <= magnitude m e) by (intro; apply magnitude_pos; lra).
  induction e; simpl; try lra;
    repeat apply Rplus_le_compat; try (apply Rmult_le_compat); auto.
Qed.

Lemma exact_fused keep e : exact (fused_but keep e) = exact e.
Proof. induction e; cbn [fused_but]; destruct (keep _); cbn [exact]; congruence. Qed.
Lemma magnitude_fused keep m e : magnitude m (fused_but keep e) = magnitude m e.
Proof. induction e; cbn [fused_but]; destruct (keep _); cbn [magnitude]; congruence. Qed.
End Values.

Lemma depth_fused keep e : (depth (fused_but keep e) <= depth e)%nat.
Proof. induction e; cbn [fused_but]; destruct (keep _); cbn [depth]; lia. Qed.
Lemma losses_fused keep e : (losses (fused_but keep e) <= losses e)%nat.
Proof. induction e; cbn [fused_but]; destruct (keep _); cbn [losses]; lia. Qed.

Lemma pow_le x n : 0 <= x <= / 2 ^ 24 -> (n <= 64)%nat -> (1 + x) ^ n <= 1 + INR n * (x * (1 + / 2 ^ 16)).
Proof.
  intros X N. induction n; [simpl; lra|]. specialize (IHn ltac:(lia)).
  assert (INR n <= INR 64) by (apply le_INR; lia). replace (INR 64) with 64 in * by (simpl; lra).
  pose proof (pos_INR n). rewrite S_INR. cbn [pow].
  assert ((1 + x) * (1 + x) ^ n <= (1 + x) * (1 + INR n * (x * (1 + / 2 ^ 16)))) by (apply Rmult_le_compat_l; lra).
  assert (INR n * x <= 64 * / 2 ^ 24) by (apply Rmult_le_compat; lra).
  assert (x * (INR n * x * (1 + / 2 ^ 16)) <= x * (/ 2 ^ 16)) by (apply Rmult_le_compat_l; lra).
  lra.
Qed.

Section Rounding.
(** A rounding is off by at most [u] of the number, and [eta] besides where it underflows. *)
Variable rnd : R -> R.
Variables u eta : R.
Hypothesis u_pos : 0 <= u.
Hypothesis eta_pos : 0 <= eta.
Hypothesis rounds : forall x, Rabs (rnd x - x) <= u * Rabs x + eta.

(** [f i] is what is read of [v i]: zero, perhaps, where that is subnormal. *)
Variables v f : nat -> R.
Hypothesis reads : forall i, Rabs (f i - v i) <= eta.

(** The value as computed. *)
Fixpoint float e := match e with
| In i => f i | Diff i j => rnd (f i - f j) | Neg a => - float a
| Add a b => rnd (float a + float b) | Sub a b => rnd (float a - float b) | Mul a b => rnd (float a * float b)
| MulAdd a b c => rnd (rnd (float a * float b) + float c)
| MulSub a b c => rnd (rnd (float a * float b) - float c)
| Fma a b c => rnd (float a * float b + float c)
| Fms a b c => rnd (float a * float b - float c) end.

(** The permanent as computed. *)
Fixpoint float_perm e := match e with
| In i => Rabs (f i) | Diff i j => Rabs (rnd (f i - f j)) | Neg a => float_perm a
| Add a b | Sub a b => rnd (float_perm a + float_perm b)
| Mul a b => rnd (float_perm a * float_perm b)
| MulAdd a b c | MulSub a b c => rnd (rnd (float_perm a * float_perm b) + float_perm c)
| Fma a b c | Fms a b c => rnd (float_perm a * float_perm b + float_perm c) end.

Variable m : R.
Hypothesis m_ge : 1 <= m.
Definition lost := eta / m.

(** [x'] is near [x]: off by [k] roundings of [p], and by [l] losses of [q]. *)
Definition near x x' p q (k l : nat) :=
  Rabs (x' - x) <= ((1 + u) ^ k - 1) * p + (1 + u) ^ k * ((1 + lost) ^ l - 1) * q
  /\ Rabs x <= p /\ p <= q.

Lemma lost_pos : 0 <= lost.
Proof. unfold lost. apply Rmult_le_pos; [assumption|]. left. apply Rinv_0_lt_compat. lra. Qed.
Lemma lost_m : lost * m = eta.
Proof. unfold lost. field. lra. Qed.
Lemma pow_u k : 1 <= (1 + u) ^ k. Proof. apply pow_R1_Rle; lra. Qed.
Lemma pow_lost k : 1 <= (1 + lost) ^ k. Proof. pose proof lost_pos. apply pow_R1_Rle; lra. Qed.

Lemma near_weaken x x' p q k l k' l' :
  (k <= k')%nat -> (l <= l')%nat -> near x x' p q k l -> near x x' p q k' l'.
Proof.
  intros K L [E [P Q]]. split; [|auto]. pose proof (Rabs_pos x). pose proof lost_pos.
  assert ((1 + u) ^ k <= (1 + u) ^ k') by (apply Rle_pow; [lra|exact K]).
  assert ((1 + lost) ^ l <= (1 + lost) ^ l') by (apply Rle_pow; [lra|exact L]).
  pose proof (pow_u k). pose proof (pow_lost l).
  assert (((1 + u) ^ k - 1) * p <= ((1 + u) ^ k' - 1) * p) by (apply Rmult_le_compat_r; lra).
  assert ((1 + u) ^ k * ((1 + lost) ^ l - 1) * q <= (1 + u) ^ k' * ((1 + lost) ^ l' - 1) * q).
  { apply Rmult_le_compat_r; [lra|]. apply Rmult_le_compat; lra. }
  lra.
Qed.

Lemma near_rnd x x' p q k l : m <= q -> near x x' p q k l -> near x (rnd x') p q (S k) (S l).
Proof.
  intros M [E [P Q]]. split; [|auto]. pose proof lost_pos. pose proof (pow_u k). pose proof (pow_lost l).
  simpl. set (A := (1 + u) ^ k) in *. set (X := (1 + lost) ^ l) in *.
  assert (Rabs x' <= A * p + A * (X - 1) * q).
  { replace x' with ((x' - x) + x) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  replace (rnd x' - x) with ((rnd x' - x') + (x' - x)) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. pose proof (rounds x').
  assert (u * Rabs x' <= u * (A * p + A * (X - 1) * q)) by (apply Rmult_le_compat_l; lra).
  assert (eta <= lost * q) by (rewrite <- lost_m; apply Rmult_le_compat_l; lra).
  assert (1 <= (1 + u) * A) by (replace 1 with (1 * 1) by ring; apply Rmult_le_compat; lra).
  assert (1 * 1 <= ((1 + u) * A) * X) by (apply Rmult_le_compat; lra).
  assert (0 <= lost * q) by (apply Rmult_le_pos; lra).
  assert (1 * (lost * q) <= ((1 + u) * A * X) * (lost * q)) by (apply Rmult_le_compat_r; lra).
  nra.
Qed.

Lemma near_add x x' p q y y' r s k l :
  near x x' p q k l -> near y y' r s k l -> near (x + y) (x' + y') (p + r) (q + s) k l.
Proof.
  intros [E [P Q]] [F [R S]]. split; [|split; [|lra]].
  - replace (x' + y' - (x + y)) with ((x' - x) + (y' - y)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. lra.
  - eapply Rle_trans; [apply Rabs_triang|]. lra.
Qed.

Lemma near_neg x x' p q k l : near x x' p q k l -> near (- x) (- x') p q k l.
Proof.
  intros [E [P Q]]. split; [|split; [|exact Q]].
  - replace (- x' - - x) with (- (x' - x)) by ring. rewrite Rabs_Ropp. exact E.
  - rewrite Rabs_Ropp. exact P.
Qed.

Lemma near_sub x x' p q y y' r s k l :
  near x x' p q k l -> near y y' r s k l -> near (x - y) (x' - y') (p + r) (q + s) k l.
Proof. intros E F. apply near_add; [exact E|]. apply near_neg. exact F. Qed.

Lemma near_mul x x' p q y y' r s k l k' l' :
  near x x' p q k l -> near y y' r s k' l' -> near (x * y) (x' * y') (p * r) (q * s) (k + k') (l + l').
Proof.
  intros [E [P Q]] [F [R S]].
  pose proof (Rabs_pos x). pose proof (Rabs_pos y). pose proof (Rabs_pos (x' - x)). pose proof (Rabs_pos (y' - y)).
  pose proof (pow_u k). pose proof (pow_u k'). pose proof (pow_lost l). pose proof (pow_lost l').
  split; [|split].
  - replace (x' * y' - x * y) with ((x' - x) * (y' - y) + (x * (y' - y) + (x' - x) * y)) by ring.
    eapply Rle_trans; [apply Rabs_triang|].
    eapply Rle_trans; [apply Rplus_le_compat_l; apply Rabs_triang|].
    rewrite !Rabs_mult, !pow_add.
    set (A := (1 + u) ^ k) in *. set (B := (1 + u) ^ k') in *.
    set (X := (1 + lost) ^ l) in *. set (Y := (1 + lost) ^ l') in *.
    set (e := (A - 1) * p + A * (X - 1) * q) in *. set (g := (B - 1) * r + B * (Y - 1) * s) in *.
    assert (Rabs (x' - x) * Rabs (y' - y) <= e * g) by (apply Rmult_le_compat; lra).
    assert (Rabs x * Rabs (y' - y) <= p * g) by (apply Rmult_le_compat; lra).
    assert (Rabs (x' - x) * Rabs y <= e * r) by (apply Rmult_le_compat; lra).
    assert (0 <= A * B) by (apply Rmult_le_pos; lra).
    assert (p * s <= q * s) by (apply Rmult_le_compat_r; lra).
    assert (q * r <= q * s) by (apply Rmult_le_compat_l; lra).
    assert (A * B * (Y - 1) * (p * s) <= A * B * (Y - 1) * (q * s)).
    { apply Rmult_le_compat_l; [apply Rmult_le_pos; lra|assumption]. }
    assert (A * B * (X - 1) * (q * r) <= A * B * (X - 1) * (q * s)).
    { apply Rmult_le_compat_l; [apply Rmult_le_pos; lra|assumption]. }
    replace ((A * B - 1) * (p * r) + A * B * (X * Y - 1) * (q * s))
      with ((e * g + p * g + e * r)
            + (A * B * (Y - 1) * (q * s) - A * B * (Y - 1) * (p * s))
            + (A * B * (X - 1) * (q * s) - A * B * (X - 1) * (q * r))) by (unfold e, g; ring).
    lra.
  - rewrite Rabs_mult. apply Rmult_le_compat; lra.
  - apply Rmult_le_compat; lra.
Qed.

Lemma near_refl x p q : Rabs x <= p -> p <= q -> near x x p q 0 0.
Proof.
  intros P Q. split; [|auto]. replace (x - x) with 0 by ring. rewrite Rabs_R0. simpl. lra.
Qed.

Lemma near_sign s x x' p q k l : s = 1 \/ s = -1 -> near x x' p q k l -> near (s * x) (s * x') p q k l.
Proof.
  intros [-> | ->] N; [rewrite !Rmult_1_l; exact N|].
  replace (-1 * x) with (- x) by ring. replace (-1 * x') with (- x') by ring. apply near_neg. exact N.
Qed.

Lemma near_more x x' p q q' k l : q <= q' -> near x x' p q k l -> near x x' p q' k l.
Proof.
  intros M [E [P Q0]]. split; [|split; [exact P|lra]].
  pose proof (pow_u k). pose proof (pow_lost l).
  assert ((1 + u) ^ k * ((1 + lost) ^ l - 1) * q <= (1 + u) ^ k * ((1 + lost) ^ l - 1) * q').
  { apply Rmult_le_compat_l; [apply Rmult_le_pos; lra|exact M]. }
  lra.
Qed.

Lemma near_in i : near (v i) (f i) (Rabs (v i) + 0) (Rabs (v i) + m) 0 1.
Proof.
  pose proof (Rabs_pos (v i)). pose proof lost_pos. pose proof (reads i). split; [|split; lra]. simpl.
  assert (0 <= lost * Rabs (v i)) by (apply Rmult_le_pos; assumption). pose proof lost_m. nra.
Qed.

Lemma near_difference i j :
  near (v i - v j) (f i - f j) (Rabs (v i - v j) + 0) (Rabs (v i - v j) + m) 0 2.
Proof.
  pose proof (Rabs_pos (v i - v j)). pose proof lost_pos. pose proof (reads i). pose proof (reads j).
  split; [|split; lra].
  replace (f i - f j - (v i - v j)) with ((f i - v i) + - (f j - v j)) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. simpl.
  assert (0 <= lost * Rabs (v i - v j)) by (apply Rmult_le_pos; assumption). pose proof lost_m.
  assert (0 <= lost * lost * (Rabs (v i - v j) + m)) by (apply Rmult_le_pos; [apply Rmult_le_pos|]; lra).
  nra.
Qed.

Lemma large a : m <= magnitude v m a. Proof. apply magnitude_ge. exact m_ge. Qed.
Lemma large_mul a b : m <= magnitude v m a * magnitude v m b.
Proof. exact (large (Mul a b)). Qed.

Ltac deeper := eapply near_weaken; [| |eassumption]; lia.

(** What is computed is within [depth] roundings of the permanent of what is meant, but for underflow. *)
Theorem bounded e : near (exact v e) (float e) (perm v e) (magnitude v m e) (depth e) (losses e).
Proof.
  unfold perm. induction e; cbn [exact float magnitude depth losses].
  - apply near_in.
  - apply near_rnd; [exact (large (Diff i j))|apply near_difference].
  - apply near_neg; assumption.
  - apply near_rnd; [exact (large (Add e1 e2))|]. apply near_add; deeper.
  - apply near_rnd; [exact (large (Sub e1 e2))|]. apply near_sub; deeper.
  - apply near_rnd; [apply large_mul|]. apply near_mul; assumption.
  - apply near_rnd; [exact (large (MulAdd e1 e2 e3))|]. apply near_add; [|deeper].
    eapply near_weaken; [| |apply near_rnd; [apply large_mul|apply near_mul; eassumption]]; lia.
  - apply near_rnd; [exact (large (MulSub e1 e2 e3))|]. apply near_sub; [|deeper].
    eapply near_weaken; [| |apply near_rnd; [apply large_mul|apply near_mul; eassumption]]; lia.
  - apply near_rnd; [exact (large (Fma e1 e2 e3))|]. apply near_add; [|deeper].
    eapply near_weaken; [| |apply near_mul; eassumption]; lia.
  - apply near_rnd; [exact (large (Fms e1 e2 e3))|]. apply near_sub; [|deeper].
    eapply near_weaken; [| |apply near_mul; eassumption]; lia.
Qed.

Lemma near_abs x x' p q k l : near x x' p q k l -> near (Rabs x) (Rabs x') p q k l.
Proof.
  intros [E [P Q]]. split; [|split; [rewrite Rabs_Rabsolu; exact P|exact Q]].
  eapply Rle_trans; [apply Rabs_triang_inv2|exact E].
Qed.

(** So is the permanent itself. *)
Theorem perm_bounded e : near (perm v e) (float_perm e) (perm v e) (magnitude v m e) (depth e) (losses e).
Proof.
  unfold perm. induction e; cbn [float_perm magnitude depth losses].
  - replace (Rabs (v i) + 0) with (Rabs (v i)) at 1 by ring. apply near_abs, near_in.
  - replace (Rabs (v i - v j) + 0) with (Rabs (v i - v j)) at 1 by ring.
    apply near_abs, near_rnd; [exact (large (Diff i j))|apply near_difference].
  - assumption.
  - apply near_rnd; [exact (large (Add e1 e2))|]. apply near_add; deeper.
  - apply near_rnd; [exact (large (Sub e1 e2))|]. apply near_add; deeper.
  - apply near_rnd; [apply large_mul|]. apply near_mul; assumption.
  - apply near_rnd; [exact (large (MulAdd e1 e2 e3))|]. apply near_add; [|deeper].
    eapply near_weaken; [| |apply near_rnd; [apply large_mul|apply near_mul; eassumption]]; lia.
  - apply near_rnd; [exact (large (MulSub e1 e2 e3))|]. apply near_add; [|deeper].
    eapply near_weaken; [| |apply near_rnd; [apply large_mul|apply near_mul; eassumption]]; lia.
  - apply near_rnd; [exact (large (Fma e1 e2 e3))|]. apply near_add; [|deeper].
    eapply near_weaken; [| |apply near_mul; eassumption]; lia.
  - apply near_rnd; [exact (large (Fms e1 e2 e3))|]. apply near_add; [|deeper].
    eapply near_weaken; [| |apply near_mul; eassumption]; lia.
Qed.

(** The same in numbers. *)
Theorem near_within x x' p q k l : near x x' p q k l -> u <= / 2 ^ 24 -> lost <= / 2 ^ 24 ->
  (k <= 16)%nat -> (l <= 32)%nat ->
  Rabs (x' - x) <= INR k * (u * (1 + / 2 ^ 16)) * p + (INR l + / 8) * lost * q.
Proof.
  intros [E [P Q]] U1 L1 K L. pose proof (Rabs_pos x). pose proof lost_pos.
  pose proof (pow_le u k ltac:(lra) ltac:(lia)). pose proof (pow_le lost l ltac:(lra) ltac:(lia)).
  pose proof (pow_u k). pose proof (pow_lost l).
  assert (INR k <= INR 16) by (apply le_INR; lia). replace (INR 16) with 16 in * by (simpl; lra).
  assert (INR l <= INR 32) by (apply le_INR; lia). replace (INR 32) with 32 in * by (simpl; lra).
  pose proof (pos_INR k). pose proof (pos_INR l).
  assert (((1 + u) ^ k - 1) * p <= INR k * (u * (1 + / 2 ^ 16)) * p) by (apply Rmult_le_compat_r; lra).
  assert (INR k * (u * (1 + / 2 ^ 16)) <= 16 * (/ 2 ^ 24 * (1 + / 2 ^ 16))) by (apply Rmult_le_compat; lra).
  assert ((1 + u) ^ k * ((1 + lost) ^ l - 1) <= (1 + / 2 ^ 19) * (INR l * (lost * (1 + / 2 ^ 16)))) by (apply Rmult_le_compat; lra).
  assert (INR l * lost <= 32 * lost) by (apply Rmult_le_compat_r; lra).
  assert ((1 + u) ^ k * ((1 + lost) ^ l - 1) <= (INR l + / 8) * lost) by lra.
  assert ((1 + u) ^ k * ((1 + lost) ^ l - 1) * q <= (INR l + / 8) * lost * q) by (apply Rmult_le_compat_r; lra).
  lra.
Qed.
End Rounding.
