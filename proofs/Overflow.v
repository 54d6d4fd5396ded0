(** Nothing overflows where the filter's bound says something: no number that it computes on the way to the volumes, each
    rounding and each product of a multiply-add included, exceeds half the inverse of the smallest normal number, which is
    2¹²⁵ in f32 and 2¹⁰²¹ in f64. *)
Require Import List Reals Lra Lia Psatz.
Import ListNotations.
Require Import Trisect.Bound Trisect.Float Trisect.Methods Trisect.Norms Trisect.Filter Trisect.Hit.
Open Scope R_scope.

Section Below.
Variable rnd : R -> R.
Variables u eta : R.
Hypothesis precise : 0 < u <= / 2 ^ 24.
Hypothesis small : 0 <= eta <= / 2 ^ 24.
Hypothesis rounds : forall x, Rabs (rnd x - x) <= u * Rabs x + eta.
Variables v f : nat -> R.
Hypothesis reads : forall i, Rabs (f i - v i) <= eta.

(** No number on the way to [e], before it is rounded, is larger than [B]. *)
Fixpoint below (B : R) e : Prop := match e with
| In i => Rabs (f i) <= B
| Diff i j => Rabs (f i - f j) <= B
| Neg a => below B a
| Add a b => below B a /\ below B b /\ Rabs (float rnd f a + float rnd f b) <= B
| Sub a b => below B a /\ below B b /\ Rabs (float rnd f a - float rnd f b) <= B
| Mul a b => below B a /\ below B b /\ Rabs (float rnd f a * float rnd f b) <= B
| MulAdd a b c => below B a /\ below B b /\ below B c /\ Rabs (float rnd f a * float rnd f b) <= B
    /\ Rabs (rnd (float rnd f a * float rnd f b) + float rnd f c) <= B
| MulSub a b c => below B a /\ below B b /\ below B c /\ Rabs (float rnd f a * float rnd f b) <= B
    /\ Rabs (rnd (float rnd f a * float rnd f b) - float rnd f c) <= B
| Fma a b c => below B a /\ below B b /\ below B c /\ Rabs (float rnd f a * float rnd f b + float rnd f c) <= B
| Fms a b c => below B a /\ below B b /\ below B c /\ Rabs (float rnd f a * float rnd f b - float rnd f c) <= B end.

Notation M := (magnitude v 1).
Let u_pos : 0 <= u. Proof. lra. Qed.
Let eta_pos : 0 <= eta. Proof. lra. Qed.
Notation near := (near u eta 1).

Lemma near_size x x' p q k l : near x x' p q k l -> (k <= 32)%nat -> (l <= 32)%nat -> Rabs x' <= 2 * q.
Proof.
  intros [E [P Q]] K L. pose proof (Rabs_pos x). replace (lost eta 1) with eta in E by (unfold lost; field).
  pose proof (pow_le u k ltac:(lra) ltac:(lia)). pose proof (pow_le eta l ltac:(lra) ltac:(lia)).
  pose proof (pow_u u u_pos k). assert (1 <= (1 + eta) ^ l) by (apply pow_R1_Rle; lra).
  assert (INR k <= INR 32) by (apply le_INR; lia). assert (INR l <= INR 32) by (apply le_INR; lia).
  replace (INR 32) with 32 in * by (simpl; lra). pose proof (pos_INR k). pose proof (pos_INR l).
  assert (INR k * (u * (1 + / 2 ^ 16)) <= 32 * (/ 2 ^ 24 * (1 + / 2 ^ 16))) by (apply Rmult_le_compat; lra || (apply Rmult_le_pos; lra)).
  assert (INR l * (eta * (1 + / 2 ^ 16)) <= 32 * (/ 2 ^ 24 * (1 + / 2 ^ 16))) by (apply Rmult_le_compat; lra || (apply Rmult_le_pos; lra)).
  set (A := (1 + u) ^ k) in *. set (X := (1 + eta) ^ l) in *.
  assert (Rabs x' <= A * p + A * (X - 1) * q).
  { replace x' with (x + (x' - x)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
  assert (A * p <= (1 + / 4) * q) by (apply Rmult_le_compat; lra).
  assert (A * (X - 1) * q <= (1 + / 4) * / 4 * q) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat; lra]). lra.
Qed.

Lemma below_more B B' e : B <= B' -> below B e -> below B' e.
Proof. intro H. clear - H. induction e; cbn [below]; intuition lra. Qed.

Lemma value e : near (exact v e) (float rnd f e) (perm v e) (M e) (depth e) (losses e).
Proof. apply bounded; try assumption. lra. Qed.

(** Each is at most twice what the whole comes to with 1 added to each magnitude. *)
Theorem below_magnitude e : (depth e <= 32)%nat -> (losses e <= 32)%nat -> below (2 * M e) e.
Proof.
  assert (O : forall e, 1 <= M e) by (intro; apply magnitude_ge; lra).
  assert (P : forall a b, M a <= M a * M b /\ M b <= M a * M b /\ 1 <= M a * M b).
  { intros a b. pose proof (O a). pose proof (O b). assert (M a * 1 <= M a * M b) by (apply Rmult_le_compat_l; lra).
    assert (1 * M b <= M a * M b) by (apply Rmult_le_compat_r; lra). lra. }
  assert (Up : forall a B k l, ((k <= 32)%nat -> (l <= 32)%nat -> below (2 * M a) a) -> (k <= 32)%nat -> (l <= 32)%nat -> M a <= B -> below (2 * B) a).
  { intros a B k l H K L LE. apply below_more with (2 * M a); [lra|auto]. }
  induction e; cbn [below depth losses magnitude]; intros K L;
    try (pose proof (O e1) as O1; pose proof (O e2) as O2; pose proof (P e1 e2) as P12);
    try (pose proof (value e1) as N1; pose proof (value e2) as N2).
  - eapply near_size; [apply (near_in u eta); assumption || lra| |]; lia.
  - eapply near_size; [apply (near_difference u eta); assumption || lra| |]; lia.
  - apply IHe; lia.
  - repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|].
    eapply near_size with (k := Nat.max (depth e1) (depth e2)) (l := Nat.max (losses e1) (losses e2)); [|lia|lia].
    apply near_add; eapply near_weaken; try eassumption; lra || lia.
  - repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|].
    eapply near_size with (k := Nat.max (depth e1) (depth e2)) (l := Nat.max (losses e1) (losses e2)); [|lia|lia].
    apply near_sub; eapply near_weaken; try eassumption; lra || lia.
  - repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|].
    eapply near_size; [apply near_mul; eassumption || lra| |]; lia.
  - pose proof (O e3) as O3. pose proof (value e3) as N3.
    assert (N12 : near (exact v e1 * exact v e2) (float rnd f e1 * float rnd f e2) (perm v e1 * perm v e2) (M e1 * M e2) (depth e1 + depth e2) (losses e1 + losses e2))
      by (apply near_mul; assumption || lra).
    repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|eapply Up; [exact IHe3| | |]; lia || lra| |].
    + apply Rle_trans with (2 * (M e1 * M e2)); [eapply near_size; [exact N12| |]; lia|lra].
    + eapply near_size with (k := Nat.max (S (depth e1 + depth e2)) (depth e3)) (l := Nat.max (S (losses e1 + losses e2)) (losses e3)); [|lia|lia].
      apply near_add; [|eapply near_weaken; try eassumption; lra || lia].
      eapply near_weaken; [| | | | |apply near_rnd; [assumption|assumption|assumption|apply Rle_refl| |exact N12]]; lra || lia.
  - pose proof (O e3) as O3. pose proof (value e3) as N3.
    assert (N12 : near (exact v e1 * exact v e2) (float rnd f e1 * float rnd f e2) (perm v e1 * perm v e2) (M e1 * M e2) (depth e1 + depth e2) (losses e1 + losses e2))
      by (apply near_mul; assumption || lra).
    repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|eapply Up; [exact IHe3| | |]; lia || lra| |].
    + apply Rle_trans with (2 * (M e1 * M e2)); [eapply near_size; [exact N12| |]; lia|lra].
    + eapply near_size with (k := Nat.max (S (depth e1 + depth e2)) (depth e3)) (l := Nat.max (S (losses e1 + losses e2)) (losses e3)); [|lia|lia].
      apply near_sub; [|eapply near_weaken; try eassumption; lra || lia].
      eapply near_weaken; [| | | | |apply near_rnd; [assumption|assumption|assumption|apply Rle_refl| |exact N12]]; lra || lia.
  - pose proof (O e3) as O3. pose proof (value e3) as N3.
    repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|eapply Up; [exact IHe3| | |]; lia || lra|].
    eapply near_size with (k := Nat.max (depth e1 + depth e2) (depth e3)) (l := Nat.max (losses e1 + losses e2) (losses e3)); [|lia|lia].
    apply near_add; [|eapply near_weaken; try eassumption; lra || lia].
    eapply near_weaken; [| | | | |apply near_mul; eassumption || lra]; lra || lia.
  - pose proof (O e3) as O3. pose proof (value e3) as N3.
    repeat split; [eapply Up; [exact IHe1| | |]; lia || lra|eapply Up; [exact IHe2| | |]; lia || lra|eapply Up; [exact IHe3| | |]; lia || lra|].
    eapply near_size with (k := Nat.max (depth e1 + depth e2) (depth e3)) (l := Nat.max (losses e1 + losses e2) (losses e3)); [|lia|lia].
    apply near_sub; [|eapply near_weaken; try eassumption; lra || lia].
    eapply near_weaken; [| | | | |apply near_mul; eassumption || lra]; lra || lia.
Qed.
End Below.

Section Filter.
Variable rnd : R -> R.
Variables u eta : R.
Hypothesis arithmetic : rounding rnd u eta.
Hypothesis precise : 0 < u <= / 2 ^ 24.
Hypothesis wide : 0 <= eta <= u * / 2 ^ 102.
Variables v f : nat -> R.
Hypothesis reads : forall i, Rabs (f i - v i) <= eta.
Variables fuse stored : bool.
Hypothesis is_fast : SLOWEST <= size rnd f.
Hypothesis no_finer : / 2 ^ 53 <= u.
Hypothesis is_bounded : bound rnd u f fuse < NO_BOUND.

Notation "'use' l" := (l rnd u eta arithmetic precise wide v f reads fuse stored is_fast) (at level 10, l at level 9).
Let d := size rnd f.
Let g := h rnd f.
Let r := g + 2 * distance rnd f.

Lemma eta_magnitude e : List.In e [det; U; V; W; T] -> eta * (4 * magnitude v 1 e) <= 1.
Proof.
  pose proof (use bound_ge) as B. cbv zeta in B. fold d g r in B.
  pose proof (use rho_ge) as R. fold g r in R. pose proof (use h_ge) as H. fold g in H. pose proof is_fast as D. fold d in D.
  pose proof (use distance_pos) as S0.
  pose proof (use d1_le) as D1. fold d in D1. pose proof (use d1_pos) as D0. pose proof (use rho'_le) as R1. cbv zeta in R1. fold g r in R1.
  pose proof (use S'_pos) as Sp. assert (H1 : h' rnd f <= (1 + / 2 ^ 10) * g) by (unfold h', SHORTEST in *; fold g; lra).
  assert (Hp : 0 <= h' rnd f) by (unfold h', SHORTEST in *; fold g; lra).
  unfold SHORTEST, SLOWEST, FACTOR, NO_BOUND in *.
  assert (Hr : g <= r) by (unfold r; lra).
  set (q := d * g * r) in *. assert (Q : u * q <= 2 ^ 26) by lra.
  assert (q0 : 0 <= q) by (unfold q; repeat apply Rmult_le_pos; lra).
  assert (E : eta * q <= / 2 ^ 76).
  { assert (eta * q <= u * / 2 ^ 102 * q) by (apply Rmult_le_compat_r; lra). lra. }
  assert (Div : forall x y c, 0 <= x -> 0 < c -> / c <= y -> x <= c * (x * y)).
  { intros x y k X C Y. assert (x * / k <= x * y) by (apply Rmult_le_compat_l; assumption).
    apply Rmult_le_reg_l with (/ k); [apply Rinv_0_lt_compat; exact C|].
    replace (/ k * (k * (x * y))) with (x * y) by (field; lra). lra. }
  assert (P : forall x y, 0 <= x -> 0 <= y -> 0 <= x * y) by (intros; apply Rmult_le_pos; assumption).
  assert (Pdg : 0 <= d * g) by (apply P; lra). assert (Pdr : 0 <= d * r) by (apply P; lra). assert (Pgr : 0 <= g * r) by (apply P; lra).
  assert (dg : eta * (d * g) <= / 2 ^ 42).
  { pose proof (Div (eta * (d * g)) r (2 ^ 34) ltac:(apply P; lra) ltac:(lra) ltac:(lra)) as X.
    replace (eta * (d * g) * r) with (eta * q) in X by (unfold q; ring). lra. }
  assert (dr : eta * (d * r) <= / 2 ^ 42).
  { pose proof (Div (eta * (d * r)) g (2 ^ 34) ltac:(apply P; lra) ltac:(lra) ltac:(lra)) as X.
    replace (eta * (d * r) * g) with (eta * q) in X by (unfold q; ring). lra. }
  assert (gr : eta * (g * r) <= / 2 ^ 56).
  { pose proof (Div (eta * (g * r)) d (2 ^ 20) ltac:(apply P; lra) ltac:(lra) ltac:(lra)) as X.
    replace (eta * (g * r) * d) with (eta * q) in X by (unfold q; ring). lra. }
  assert (ed : eta * d <= / 2 ^ 8).
  { pose proof (Div (eta * d) g (2 ^ 34) ltac:(apply P; lra) ltac:(lra) ltac:(lra)) as X.
    replace (eta * d * g) with (eta * (d * g)) in X by ring. lra. }
  assert (er : eta * r <= / 2 ^ 22).
  { pose proof (Div (eta * r) g (2 ^ 34) ltac:(apply P; lra) ltac:(lra) ltac:(lra)) as X.
    replace (eta * r * g) with (eta * (g * r)) in X by ring. lra. }
  assert (eg : eta * g <= / 2 ^ 22) by (assert (eta * g <= eta * r) by (apply Rmult_le_compat_l; lra); lra).
  assert (e1 : eta <= / 2 ^ 126) by (assert (u * / 2 ^ 102 <= / 2 ^ 24 * / 2 ^ 102) by (apply Rmult_le_compat_r; lra); lra).
  assert (egg : eta * (g * g) <= / 2 ^ 56).
  { assert (g * g <= g * r) by (apply Rmult_le_compat_l; lra). assert (eta * (g * g) <= eta * (g * r)) by (apply Rmult_le_compat_l; lra). lra. }
  assert (gsmall : g <= 2 ^ 50).
  { apply Rnot_lt_le. intro G. assert (2 ^ 50 * 2 ^ 50 <= g * r) by (apply Rmult_le_compat; lra).
    pose proof (Div (u * (g * r)) d (2 ^ 20) ltac:(apply P; lra) ltac:(lra) ltac:(lra)) as X.
    replace (u * (g * r) * d) with (u * q) in X by (unfold q; ring).
    assert (/ 2 ^ 53 * (2 ^ 50 * 2 ^ 50) <= u * (g * r)) by (apply Rmult_le_compat; lra). lra. }
  assert (ggr : eta * (g * r) * g <= / 2 ^ 56 * 2 ^ 50) by (apply Rmult_le_compat; try apply P; lra).
  pose proof (w_norm v _ _ 1 (use is_sized) Rle_0_1) as Nw. pose proof (t_norm v _ _ 1 (use is_sized) Rle_0_1) as Nt.
  set (hp := h' rnd f) in *. set (sp := S' rnd eta f) in *.
  assert (Mw : magnitude v 1 W <= 2 * (((1 + / 2 ^ 10) * d + 3) * ((1 + / 2 ^ 10) * g + 1) * ((1 + / 2 ^ 10) * r + 3))).
  { eapply Rle_trans; [exact Nw|]. rewrite !Rmult_assoc. apply Rmult_le_compat_l; [lra|].
    apply Rmult_le_compat; try lra; [apply P; lra|]. apply Rmult_le_compat; lra. }
  assert (Mt : magnitude v 1 T <= 6 * (((1 + / 2 ^ 10) * r + 1) * (((1 + / 2 ^ 10) * g + 1) * ((1 + / 2 ^ 10) * g + 1)))).
  { eapply Rle_trans; [exact Nt|]. rewrite Rmult_assoc. apply Rmult_le_compat_l; [lra|]. replace ((hp + 1) ^ 2) with ((hp + 1) * (hp + 1)) by ring.
    apply Rmult_le_compat; try lra; [apply P; lra|]. apply Rmult_le_compat; lra. }
  assert (Ew : eta * (4 * magnitude v 1 W) <= 1).
  { apply Rle_trans with (eta * (4 * (2 * (((1 + / 2 ^ 10) * d + 3) * ((1 + / 2 ^ 10) * g + 1) * ((1 + / 2 ^ 10) * r + 3)))));
      [apply Rmult_le_compat_l; lra|].
    set (k := 1 + / 2 ^ 10).
    replace (eta * (4 * (2 * ((k * d + 3) * (k * g + 1) * (k * r + 3)))))
      with (8 * (k * k * k * (eta * q) + 3 * k * k * (eta * (d * g)) + k * k * (eta * (d * r)) + 3 * k * (eta * d)
            + 3 * k * k * (eta * (g * r)) + 9 * k * (eta * g) + 3 * k * (eta * r) + 9 * eta)) by (unfold q; ring).
    unfold k. lra. }
  assert (Et : eta * (4 * magnitude v 1 T) <= 1).
  { apply Rle_trans with (eta * (4 * (6 * (((1 + / 2 ^ 10) * r + 1) * (((1 + / 2 ^ 10) * g + 1) * ((1 + / 2 ^ 10) * g + 1))))));
      [apply Rmult_le_compat_l; lra|].
    set (k := 1 + / 2 ^ 10).
    replace (eta * (4 * (6 * ((k * r + 1) * ((k * g + 1) * (k * g + 1))))))
      with (24 * (k * k * k * (eta * (g * r) * g) + 2 * k * k * (eta * (g * r)) + k * (eta * r)
            + k * k * (eta * (g * g)) + 2 * k * (eta * g) + eta)) by ring.
    unfold k. lra. }
  intros [<-|I]; [|destruct I as [<-|[<-|[<-|[<-|[]]]]]]; try exact Ew; try exact Et;
    (eapply Rle_trans; [|exact Ew]; apply Rmult_le_compat_l; [lra|]; apply Rmult_le_compat_l; [lra|];
     apply (use in_w); simpl; tauto).
Qed.

(** The volumes, plain and fused. *)
Theorem nothing_overflows e : List.In e [det; U; V; W; T] -> 0 < eta -> below rnd f (/ (2 * eta)) (form fuse stored e).
Proof.
  intros I E. pose proof (eta_magnitude e I) as M.
  assert (B : below rnd f (2 * magnitude v 1 (form fuse stored e)) (form fuse stored e)).
  { apply (below_magnitude rnd u eta); try assumption; [lra|apply (rounds _ _ _ arithmetic)| |].
    - unfold form. destruct fuse; [eapply PeanoNat.Nat.le_trans; [apply depth_fused|]|];
        destruct I as [<-|[<-|[<-|[<-|[<-|[]]]]]]; apply PeanoNat.Nat.leb_le; reflexivity.
    - unfold form. destruct fuse; [eapply PeanoNat.Nat.le_trans; [apply losses_fused|]|];
        destruct I as [<-|[<-|[<-|[<-|[<-|[]]]]]]; apply PeanoNat.Nat.leb_le; reflexivity. }
  assert (Same : magnitude v 1 (form fuse stored e) = magnitude v 1 e) by (unfold form; destruct fuse; [apply magnitude_fused|reflexivity]).
  rewrite Same in B. eapply below_more; [|exact B].
  apply Rmult_le_reg_l with (2 * eta); [lra|]. rewrite Rinv_r by lra. lra.
Qed.
End Filter.
