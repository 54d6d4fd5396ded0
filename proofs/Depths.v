(** How many roundings a term goes through, at most, in the numerators of each method that is made of sums and
    products. *)
Require Import Trisect.Bound Trisect.Methods.
Theorem exact_det_roundings : depth exact_det = 7. Proof. reflexivity. Qed.
Theorem exact_t_roundings : depth exact_t = 8. Proof. reflexivity. Qed.
Theorem exact_alpha_roundings : depth exact_alpha = 9. Proof. reflexivity. Qed.
Theorem exact_beta_roundings : depth exact_beta = 7. Proof. reflexivity. Qed.
Theorem exact_gamma_roundings : depth exact_gamma = 7. Proof. reflexivity. Qed.
