(** What the documents claim of the project's kernels, for each arithmetic that they run in. All else leads here. *)
Require Import List Reals Lra Lia.
Import ListNotations.
Require Import Trisect.Bound Trisect.Float Trisect.Norms.
Require Trisect.Filter Trisect.Hit Trisect.Overflow Trisect.Double Trisect.Slabs.
Open Scope R_scope.

(** Ends of the interval are brought within this. *)
Definition LATEST := 2 ^ 60.

(** The ray hits the closed triangle at [t]. *)
Definition hits v t := exists beta gamma, meets v t beta gamma /\ 0 <= beta /\ 0 <= gamma /\ beta + gamma <= 1.

Section Kernel.
(** f32 or f64, flushing subnormal numbers or not; multiply-add fused or not; the normal stored or not; any ray and triangle whose direction is
    not too short to be filtered. *)
Variables (rnd read : R -> R) (u eta : R).
Hypothesis on : machine rnd read u eta.
Variables fuse stored : bool.
Variable v : nat -> R.
Let f i := read (v i).
Hypothesis is_fast : Filter.SLOWEST <= Filter.size rnd f.

Let arithmetic := machine_rounds _ _ _ _ on.
Let precise := proj1 (machine_is_fine _ _ _ _ on).
Let wide := proj2 (machine_is_fine _ _ _ _ on).
Let reads i : Rabs (f i - v i) <= eta := machine_reads _ _ _ _ on (v i).
Notation computed := (Filter.computed rnd f fuse stored).
Notation bound := (Filter.bound rnd u f fuse).
Notation bound_at := (Filter.bound_at rnd u f fuse).

(** The bound that the filter computes bounds the errors of the volumes that it computes. *)
Theorem filter_bounds_errors e : List.In e [det; U; V; W] -> Rabs (computed e - exact v e) <= bound.
Proof. exact (Filter.volumes_within_bound rnd u eta arithmetic precise wide v f reads fuse stored is_fast e). Qed.

(** Its bound of [τ·det − T] does so too. *)
Theorem filter_bounds_time tau s : s = 1 \/ s = -1 ->
  Rabs (Filter.mul_sub rnd fuse tau (s * computed det) (s * computed T) - s * (tau * exact v det - exact v T)) <= bound_at tau.
Proof. exact (Filter.row_within_bound rnd u eta arithmetic precise wide v f reads fuse stored is_fast tau s). Qed.

(** Where the bound says something no number on the way to the volumes is larger than 2¹²⁵ in f32, 2¹⁰²¹ in f64. *)
Theorem filter_does_not_overflow e : bound < Hit.NO_BOUND -> List.In e [det; U; V; W; T] ->
  Overflow.below rnd f (/ (2 * eta)) (Filter.form fuse stored e).
Proof.
  intros B I. destruct (machine_limits _ _ _ _ on) as [P E].
  exact (Overflow.nothing_overflows rnd u eta arithmetic precise wide v f reads fuse stored is_fast P B e I E).
Qed.

(** A pair that the filter drops misses. *)
Theorem filter_misses_rightly : bound < Rmin (Filter.most rnd f fuse stored) (- Filter.least rnd f fuse stored) -> forall t, ~ hits v t.
Proof.
  intros H t (beta & gamma & M & P & Q & S).
  exact (Filter.certain_miss rnd u eta arithmetic precise wide v f reads fuse stored is_fast H t beta gamma M P Q S).
Qed.

Section Inside.
Hypothesis inside : bound < Rmax (Filter.least rnd f fuse stored) (- Filter.most rnd f fuse stored).
Let s := if Rlt_dec 0 (computed U) then 1 else -1.
Let row tau := Filter.mul_sub rnd fuse tau (s * computed det) (s * computed T).

Lemma facts : (s = 1 \/ s = -1) /\ 0 < s * exact v det /\
  (exists t, hits v t /\ t * exact v det = exact v T /\ forall t', hits v t' -> t' = t).
Proof.
  assert (D : (s = 1 \/ s = -1) /\ 0 < s * exact v det /\
    ((0 <= exact v U /\ 0 <= exact v V /\ 0 <= exact v W) \/ (exact v U <= 0 /\ exact v V <= 0 /\ exact v W <= 0))).
  { pose proof (Filter.certainly_inside rnd u eta arithmetic precise wide v f reads fuse stored is_fast inside) as I.
    unfold s. destruct (Rlt_dec 0 (computed U)); lra. }
  destruct D as (S & D & I). split; [exact S|]. split; [exact D|].
  assert (N : exact v det <> 0) by (intro E; rewrite E in D; lra).
  destruct (proj2 (line_meets_triangle v N) I) as (t & beta & gamma & M & rest).
  destruct (meets_volumes v _ _ _ M) as (E & _).
  exists t. split; [exists beta, gamma; auto|]. split; [exact E|].
  intros t' (beta' & gamma' & M' & _). destruct (meets_volumes v _ _ _ M') as (E' & _).
  apply Rmult_eq_reg_r with (exact v det); [lra|exact N].
Qed.

(** A pair that it calls a hit hits within the interval, whose ends it brought within [±LATEST]. *)
Theorem filter_hits_rightly tmin tmax :
  row (Rmax (- LATEST) tmin) <= - bound_at (Rmax (- LATEST) tmin) -> bound_at (Rmin LATEST tmax) <= row (Rmin LATEST tmax) ->
  exists t, hits v t /\ tmin <= t <= tmax.
Proof.
  intros A B. destruct facts as (S & D & t & Ht & E & _). exists t. split; [exact Ht|].
  pose proof (Filter.not_before rnd u eta arithmetic precise wide v f reads fuse stored is_fast s _ t S D E A).
  pose proof (Filter.not_after rnd u eta arithmetic precise wide v f reads fuse stored is_fast s _ t S D E B).
  pose proof (Rmax_r (- LATEST) tmin). pose proof (Rmin_r LATEST tmax). lra.
Qed.

(** One that it calls too early or too late is so. *)
Theorem filter_is_early_rightly tmin : - LATEST <= tmin -> bound_at (Rmax (- LATEST) tmin) < row (Rmax (- LATEST) tmin) ->
  forall t, hits v t -> t < tmin.
Proof.
  intros L A t Ht. destruct facts as (S & D & t' & _ & E & Only). rewrite (Only t Ht).
  rewrite Rmax_right in A by exact L.
  exact (Filter.before rnd u eta arithmetic precise wide v f reads fuse stored is_fast s _ t' S D E A).
Qed.
Theorem filter_is_late_rightly tmax : tmax <= LATEST -> row (Rmin LATEST tmax) < - bound_at (Rmin LATEST tmax) ->
  forall t, hits v t -> tmax < t.
Proof.
  intros L A t Ht. destruct facts as (S & D & t' & _ & E & Only). rewrite (Only t Ht).
  rewrite Rmin_right in A by exact L.
  exact (Filter.after rnd u eta arithmetic precise wide v f reads fuse stored is_fast s _ t' S D E A).
Qed.

(** [t] of a hit lies between the numbers that it computes for who orders hits. *)
Theorem filter_places_hits t : bound < Hit.NO_BOUND -> hits v t ->
  Hit.low rnd u eta f fuse stored <= t <= Hit.high rnd u eta f fuse stored.
Proof.
  intros L (beta & gamma & M & P & Q & S).
  exact (Hit.t_within rnd u eta arithmetic precise wide v f reads fuse stored is_fast t beta gamma M (conj P (conj Q S)) inside L).
Qed.
End Inside.
End Kernel.

Section Ladder.
(** The second stage, in f64, plain. *)
Variables rnd read : R -> R.
Hypothesis on : machine rnd read u64 eta64.
Variable v : nat -> R.
Let f i := read (v i).
Hypothesis differences_small : forall i j, List.In (i, j) Double.pairs -> Rabs (Double.difference rnd f i j) <= Double.LARGEST.
Hypothesis direction_small : forall i, List.In i [3; 4; 5]%nat -> Rabs (f i) <= Double.LARGEST.

Let arithmetic := machine_rounds _ _ _ _ on.
Let wide : 0 <= eta64 <= eta64. Proof. split; [unfold eta64; left; apply Rinv_0_lt_compat, pow_lt; lra|lra]. Qed.
Let reads i : Rabs (f i - v i) <= eta64 := machine_reads _ _ _ _ on (v i).

(** Each volume is within the bound that is computed from its permanent. *)
Theorem double_bounds_errors e : List.In e [Double.det; Double.U; Double.V; Double.W; Double.T] ->
  Rabs (float rnd f e - exact v e) <= Double.error rnd (float_perm rnd f e).
Proof. exact (Double.volumes_within_error rnd eta64 arithmetic wide v f reads differences_small direction_small e). Qed.

(** So is [T − τ·det]. *)
Theorem double_bounds_time tau s : Rabs tau <= Double.LARGEST -> s = 1 \/ s = -1 ->
  Rabs (rnd (s * float rnd f Double.T - rnd (tau * (s * float rnd f Double.det))) - s * (exact v T - tau * exact v det))
  <= Double.error rnd (rnd (float_perm rnd f Double.T + rnd (Rabs tau * float_perm rnd f Double.det))).
Proof.
  destruct (Double.same_volumes v) as (<- & _ & _ & _ & <-).
  exact (Double.row_within_error rnd eta64 arithmetic wide v f reads differences_small direction_small tau s).
Qed.

(** So a sign that is certain is that of the exact number. *)
Theorem double_signs : forall e e', List.In (e, e') [(Double.U, U); (Double.V, V); (Double.W, W)] ->
  (Double.error rnd (float_perm rnd f e) < float rnd f e -> 0 < exact v e') /\
  (float rnd f e < - Double.error rnd (float_perm rnd f e) -> exact v e' < 0).
Proof.
  intros e e' I. assert (exact v e = exact v e' /\ List.In e [Double.det; Double.U; Double.V; Double.W; Double.T]) as [<- K].
  { pose proof (Double.same_volumes v) as (_ & A & B & C & _).
    destruct I as [E|[E|[E|[]]]]; injection E as <- <-; (split; [assumption|]); simpl; tauto. }
  exact (Double.certain_sign _ _ _ (double_bounds_errors e K)).
Qed.
End Ladder.

(** The tracer's box test, in f32 with subnormal numbers, plain and fused, never leaves out a box with a hit. *)
Theorem boxes_are_not_discarded :
  forall fuse o d from reach fastest sign, (forall k, Rabs (o k) <= from) ->
  (forall k, (k < 3)%nat -> Rabs (d k) <= fastest) -> (exists k, (k < 3)%nat /\ Rabs (d k) = fastest) ->
  (forall k, (sign k = 1 \/ sign k = -1) /\ sign k * Rabs (d k) = d k) ->
  eta32 <= Slabs.away from reach -> (forall k, eta32 <= Slabs.speed f32 d fastest k <= 2 ^ 126) ->
  forall nearer farther, (forall k, (k < 3)%nat -> Rabs (nearer k) <= reach /\ Rabs (farther k) <= reach) ->
  forall t tmin tmax, tmin <= t <= tmax ->
  (forall k, (k < 3)%nat -> sign k * nearer k <= sign k * (o k + t * d k) <= sign k * farther k) ->
  Slabs.enters_box f32 fuse o d from reach fastest sign nearer tmin
    <= Slabs.leaves_box f32 fuse o d from reach fastest sign farther tmax.
Proof.
  intros fuse o d from reach fastest sign O D F S.
  exact (Slabs.hit_is_not_discarded f32 f32_rounds f32_rounds_finely fuse o d from reach fastest O D F sign S).
Qed.
