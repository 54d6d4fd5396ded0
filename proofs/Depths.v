(** How many roundings a term goes through at most, in the numerators [det], [t], [alpha], [beta] and [gamma] of each
    method that is made of sums and products, as recorded from its code: plain and fused. With [bounded] of Bound.v each
    is off by as many roundings of its permanent. *)
Require Import List.
Import ListNotations.
Require Import Trisect.Bound Trisect.Methods.

Definition roundings (plain with_fma : list expr) (counts : list nat) :=
  map depth plain = counts /\ map depth with_fma = counts /\ map fused plain = with_fma.
Ltac count := repeat split; reflexivity.

Theorem moller_trumbore_roundings : roundings
  [moller_trumbore_det; moller_trumbore_t; moller_trumbore_alpha; moller_trumbore_beta; moller_trumbore_gamma]
  [moller_trumbore_det_fused; moller_trumbore_t_fused; moller_trumbore_alpha_fused; moller_trumbore_beta_fused; moller_trumbore_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem moller_trumbore_1_roundings : roundings
  [moller_trumbore_1_det; moller_trumbore_1_t; moller_trumbore_1_alpha; moller_trumbore_1_beta; moller_trumbore_1_gamma]
  [moller_trumbore_1_det_fused; moller_trumbore_1_t_fused; moller_trumbore_1_alpha_fused; moller_trumbore_1_beta_fused; moller_trumbore_1_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem moller_trumbore_2_roundings : roundings
  [moller_trumbore_2_det; moller_trumbore_2_t; moller_trumbore_2_alpha; moller_trumbore_2_beta; moller_trumbore_2_gamma]
  [moller_trumbore_2_det_fused; moller_trumbore_2_t_fused; moller_trumbore_2_alpha_fused; moller_trumbore_2_beta_fused; moller_trumbore_2_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem moller_trumbore_3_roundings : roundings
  [moller_trumbore_3_det; moller_trumbore_3_t; moller_trumbore_3_alpha; moller_trumbore_3_beta; moller_trumbore_3_gamma]
  [moller_trumbore_3_det_fused; moller_trumbore_3_t_fused; moller_trumbore_3_alpha_fused; moller_trumbore_3_beta_fused; moller_trumbore_3_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem moller_trumbore_4_roundings : roundings
  [moller_trumbore_4_det; moller_trumbore_4_t; moller_trumbore_4_alpha; moller_trumbore_4_beta; moller_trumbore_4_gamma]
  [moller_trumbore_4_det_fused; moller_trumbore_4_t_fused; moller_trumbore_4_alpha_fused; moller_trumbore_4_beta_fused; moller_trumbore_4_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem kensler_shirley_roundings : roundings
  [kensler_shirley_det; kensler_shirley_t; kensler_shirley_alpha; kensler_shirley_beta; kensler_shirley_gamma]
  [kensler_shirley_det_fused; kensler_shirley_t_fused; kensler_shirley_alpha_fused; kensler_shirley_beta_fused; kensler_shirley_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem kensler_shirley_points_roundings : roundings
  [kensler_shirley_points_det; kensler_shirley_points_t; kensler_shirley_points_alpha; kensler_shirley_points_beta; kensler_shirley_points_gamma]
  [kensler_shirley_points_det_fused; kensler_shirley_points_t_fused; kensler_shirley_points_alpha_fused; kensler_shirley_points_beta_fused; kensler_shirley_points_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem kensler_shirley_normal_roundings : roundings
  [kensler_shirley_normal_det; kensler_shirley_normal_t; kensler_shirley_normal_alpha; kensler_shirley_normal_beta; kensler_shirley_normal_gamma]
  [kensler_shirley_normal_det_fused; kensler_shirley_normal_t_fused; kensler_shirley_normal_alpha_fused; kensler_shirley_normal_beta_fused; kensler_shirley_normal_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem kensler_shirley_stored_roundings : roundings
  [kensler_shirley_stored_det; kensler_shirley_stored_t; kensler_shirley_stored_alpha; kensler_shirley_stored_beta; kensler_shirley_stored_gamma]
  [kensler_shirley_stored_det_fused; kensler_shirley_stored_t_fused; kensler_shirley_stored_alpha_fused; kensler_shirley_stored_beta_fused; kensler_shirley_stored_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.

Theorem jimenez_segura_feito_roundings : roundings
  [jimenez_segura_feito_det; jimenez_segura_feito_t; jimenez_segura_feito_alpha; jimenez_segura_feito_beta; jimenez_segura_feito_gamma]
  [jimenez_segura_feito_det_fused; jimenez_segura_feito_t_fused; jimenez_segura_feito_alpha_fused; jimenez_segura_feito_beta_fused; jimenez_segura_feito_gamma_fused]
  [7; 8; 7; 7; 9].
Proof. count. Qed.

Theorem segura_feito_roundings : roundings
  [segura_feito_det; segura_feito_t; segura_feito_alpha; segura_feito_beta; segura_feito_gamma]
  [segura_feito_det_fused; segura_feito_t_fused; segura_feito_alpha_fused; segura_feito_beta_fused; segura_feito_gamma_fused]
  [9; 8; 7; 7; 7].
Proof. count. Qed.

Theorem signed_volumes_roundings : roundings
  [signed_volumes_det; signed_volumes_t; signed_volumes_alpha; signed_volumes_beta; signed_volumes_gamma]
  [signed_volumes_det_fused; signed_volumes_t_fused; signed_volumes_alpha_fused; signed_volumes_beta_fused; signed_volumes_gamma_fused]
  [9; 8; 7; 7; 7].
Proof. count. Qed.

Theorem plucker_translated_roundings : roundings
  [plucker_translated_det; plucker_translated_t; plucker_translated_alpha; plucker_translated_beta; plucker_translated_gamma]
  [plucker_translated_det_fused; plucker_translated_t_fused; plucker_translated_alpha_fused; plucker_translated_beta_fused; plucker_translated_gamma_fused]
  [11; 11; 9; 9; 9].
Proof. count. Qed.

Theorem plucker_tolerance_roundings : roundings
  [plucker_tolerance_det; plucker_tolerance_t; plucker_tolerance_alpha; plucker_tolerance_beta; plucker_tolerance_gamma]
  [plucker_tolerance_det_fused; plucker_tolerance_t_fused; plucker_tolerance_alpha_fused; plucker_tolerance_beta_fused; plucker_tolerance_gamma_fused]
  [11; 11; 9; 9; 9].
Proof. count. Qed.

Theorem plucker_roundings : roundings
  [plucker_det; plucker_t; plucker_alpha; plucker_beta; plucker_gamma]
  [plucker_det_fused; plucker_t_fused; plucker_alpha_fused; plucker_beta_fused; plucker_gamma_fused]
  [9; 8; 7; 7; 7].
Proof. count. Qed.

Theorem keidy_roundings : roundings
  [keidy_det; keidy_t; keidy_alpha; keidy_beta; keidy_gamma]
  [keidy_det_fused; keidy_t_fused; keidy_alpha_fused; keidy_beta_fused; keidy_gamma_fused]
  [20; 21; 23; 21; 21].
Proof. count. Qed.

Theorem signed_areas_roundings : roundings
  [signed_areas_det; signed_areas_t; signed_areas_alpha; signed_areas_beta; signed_areas_gamma]
  [signed_areas_det_fused; signed_areas_t_fused; signed_areas_alpha_fused; signed_areas_beta_fused; signed_areas_gamma_fused]
  [22; 20; 20; 20; 20].
Proof. count. Qed.

Theorem badouel_roundings : roundings
  [badouel_det; badouel_t; badouel_alpha; badouel_beta; badouel_gamma]
  [badouel_det_fused; badouel_t_fused; badouel_alpha_fused; badouel_beta_fused; badouel_gamma_fused]
  [12; 13; 15; 13; 13].
Proof. count. Qed.

Theorem badouel_branch_roundings : roundings
  [badouel_branch_det; badouel_branch_t; badouel_branch_alpha; badouel_branch_beta; badouel_branch_gamma]
  [badouel_branch_det_fused; badouel_branch_t_fused; badouel_branch_alpha_fused; badouel_branch_beta_fused; badouel_branch_gamma_fused]
  [12; 13; 15; 13; 13].
Proof. count. Qed.

Theorem badouel_relative_roundings : roundings
  [badouel_relative_det; badouel_relative_t; badouel_relative_alpha; badouel_relative_beta; badouel_relative_gamma]
  [badouel_relative_det_fused; badouel_relative_t_fused; badouel_relative_alpha_fused; badouel_relative_beta_fused; badouel_relative_gamma_fused]
  [12; 13; 15; 13; 13].
Proof. count. Qed.

Theorem exact_roundings : roundings
  [exact_det; exact_t; exact_alpha; exact_beta; exact_gamma]
  [exact_det_fused; exact_t_fused; exact_alpha_fused; exact_beta_fused; exact_gamma_fused]
  [7; 8; 9; 7; 7].
Proof. count. Qed.
