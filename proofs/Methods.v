Require Import Trisect.Bound.
Definition exact_n_x := MulSub (Diff 13 7) (Diff 11 8) (Mul (Diff 14 8) (Diff 10 7)).
Definition exact_n_y := MulSub (Diff 14 8) (Diff 9 6) (Mul (Diff 12 6) (Diff 11 8)).
Definition exact_n_z := MulSub (Diff 12 6) (Diff 10 7) (Mul (Diff 13 7) (Diff 9 6)).
Definition exact_r_x := MulSub (In 4) (Diff 8 2) (Mul (In 5) (Diff 7 1)).
Definition exact_r_y := MulSub (In 5) (Diff 6 0) (Mul (In 3) (Diff 8 2)).
Definition exact_r_z := MulSub (In 3) (Diff 7 1) (Mul (In 4) (Diff 6 0)).
Definition dot a b c x y z := MulAdd a x (MulAdd b y (Mul c z)).
Definition exact_det := Eval compute in dot (In 3) (In 4) (In 5) exact_n_x exact_n_y exact_n_z.
Definition exact_t := Eval compute in dot (Diff 6 0) (Diff 7 1) (Diff 8 2) exact_n_x exact_n_y exact_n_z.
Definition exact_beta := Eval compute in dot (Diff 12 6) (Diff 13 7) (Diff 14 8) exact_r_x exact_r_y exact_r_z.
Definition exact_gamma := Eval compute in dot (Diff 6 9) (Diff 7 10) (Diff 8 11) exact_r_x exact_r_y exact_r_z.
Definition exact_alpha := Eval compute in Sub (Sub exact_det exact_beta) exact_gamma.
