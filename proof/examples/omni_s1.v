(* omni_s1.v: theorems about the tube of omni_s1.c. Written from omni_s1.c, its task and its certificate; `stt-codegen theorem` asks Coq.

   1. The emitted tube. Let L and U be the edges that `omni_s1_tube` computes in float arithmetic (round to nearest even) at
   a time t in seconds, t exact or rounded once to float. Then for every t: U is at least 0.05 above L; L and U are in the
   state space; every unsafe set is behind them along a normal, by so much that every point between them is at least 0.03
   away, in some dimension, from every point of the set. At t = 0 they are in the initial set, and the initial state is
   between them. From t = 9 s on they are in the target set.

   There is no theorem yet about the closed loop with a drive of [plant].

   Unsafe sets are grown and the state space is shrunk by the body. Unsafe sets: O1, O2, O3, O4.

   What connects these with the C: the table, the constants of time, and the statements of `basis` and `edge_at` are those of
   the C text, found by Python; that loops and indices use them so is the stand-alone checker's word, which requires that the
   C is its listing. What is taken from the task was written out by Python. Assumed: IEEE-754 arithmetic without contraction,
   and that no number overflows.
*)
From Coq Require Import ZArith QArith Qreals Reals List.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube.
Import ListNotations.
Open Scope R_scope.

(* The task. Unsafe sets are grown and the state space is shrunk by the body; all numbers are exact. *)
Definition the_task : task := (Task 2 (9 # 1) [(1 # 4); (19 # 4)]
  (Box [(0 # 1); (0 # 1)] [(5 # 1); (5 # 1)]) (* state space *)
  (Box [(0 # 1); (9 # 2)] [(1 # 2); (5 # 1)]) (* initial set *)
  (Box [(9 # 2); (9 # 2)] [(5 # 1); (5 # 1)]) (* target set *)
  [(shape_of_box (Box [(1 # 1); (4 # 1)] [(2 # 1); (5 # 1)])); (* O1 *)
   (shape_of_box (Box [(2 # 1); (5 # 2)] [(3 # 1); (7 # 2)])); (* O2 *)
   (shape_of_box (Box [(1 # 1); (1 # 2)] [(2 # 1); (3 # 2)])); (* O3 *)
   (shape_of_box (Box [(4 # 1); (3 # 2)] [(5 # 1); (5 # 2)])) (* O4 *)]
  (3 # 100) (* clearance *) (1 # 20) (* smallest width *)
  [] [] (* half-spaces that cut state space and target *))%Q.

(* The table of the C: K + 3 rows of (lower, upper) by dimension, in units of 2^-20. *)
Definition the_unit : Q := (1 # 1048576).
Definition the_table : table := [
  [((-13200), 76344); (814883, 903803)];
  [(11, 87371); (786443, 873803)];
  [(13221, 98397); (758003, 843803)];
  [(26431, 109423); (729563, 813803)];
  [(39642, 120450); (701123, 783803)];
  [(52852, 131476); (672683, 753802)];
  [(66062, 142502); (644243, 723802)];
  [(93074, 169514); (615803, 693802)];
  [(120088, 196528); (587363, 663803)];
  [(147102, 223542); (594173, 670613)];
  [(174117, 250557); (600983, 677423)];
  [(201131, 277571); (607794, 684234)];
  [(228145, 304585); (614604, 691044)];
  [(255159, 331599); (617407, 693847)];
  [(282173, 358613); (617273, 693713)];
  [(309187, 385627); (617140, 693580)];
  [(336201, 412641); (617007, 693447)];
  [(363216, 439656); (616873, 693313)];
  [(390230, 466670); (619676, 696116)];
  [(417244, 493684); (631587, 708027)];
  [(444258, 520698); (643499, 719939)];
  [(471272, 547712); (655411, 731851)];
  [(498286, 574726); (667322, 743762)];
  [(525301, 601741); (679234, 755674)];
  [(552315, 628755); (691145, 767585)];
  [(579329, 655769); (703057, 779497)];
  [(606343, 682783); (714968, 791408)];
  [(633357, 709797); (726880, 803320)];
  [(660371, 736811); (738791, 815231)];
  [(687385, 763825); (750703, 827143)];
  [(714400, 790840); (762614, 839054)];
  [(741414, 817854); (774526, 850966)];
  [(768428, 844868); (786437, 862877)];
  [(795442, 871882); (786437, 862877)];
  [(768428, 844868); (786437, 862877)]
]%Z.

(* The statements of `basis` and `edge_at`: V 0 is s, V 1 to V 4 are q0 to q3, then come the results in order. *)
Definition the_code : list assignment := [
  Assignment Sub (C 1) (V 0);
  Assignment Mul (V 5) (V 5);
  Assignment Mul (V 6) (V 5);
  Assignment Mul (V 5) (V 0);
  Assignment Add (C 1) (V 8);
  Assignment Mul (C 3) (V 9);
  Assignment Mul (V 5) (V 10);
  Assignment Add (C 1) (V 11);
  Assignment Mul (V 0) (V 10);
  Assignment Add (C 1) (V 13);
  Assignment Mul (V 0) (V 0);
  Assignment Mul (V 15) (V 0);
  Assignment Mul (V 7) (V 1);
  Assignment Mul (V 12) (V 2);
  Assignment Add (V 17) (V 18);
  Assignment Mul (V 14) (V 3);
  Assignment Mul (V 16) (V 4);
  Assignment Add (V 20) (V 21);
  Assignment Add (V 19) (V 22)
].

(* The C's constants for K/t_c and for the last spline time, each by mantissa and exponent. *)
Definition the_scale : time_scale := TimeScale 14913081 (-22) 16777215 (-19).

(* P7's bound on the error of an edge, at least the certificate's; the largest difference of neighbouring Bezier coefficients by dimension; and a bound
   on the error of the emitted spline time. All three are checked. *)
Definition the_error : Q := (1 # 131072).
Definition the_step_maxima : list Z := [54030; 60002]%Z.
Definition the_time_error : Q := (9444733528689243848705 # 1237940039285380274899124224).

(* The C evaluates the spline by these statements. *)
Lemma statements : the_code = basis_edge.
Proof. reflexivity. Qed.

(* How Coq searches for P1 to P5; nothing in it is believed. It has the number of times that a segment may be halved, and normals for every unsafe set. *)
Definition the_search : search_plan := SearchPlan 20 [[]; []; []; []].

(* The exact tube has P1 to P5, with room for the error. *)
Lemma tube_checked : tube_check the_unit the_error the_search the_task the_table = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* The edges are no faster than the_step_maxima says. *)
Lemma slopes_checked : slopes_check the_error the_task the_table the_step_maxima = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* P7: the arithmetic moves no edge by more than the error. *)
Lemma rounding_checked : rounding_check Single the_unit the_error the_task the_table the_step_maxima the_scale the_time_error = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* 1. The emitted tube. *)
Theorem emitted_tube : forall clock : R -> R, (forall t, clock_shows Single (clock t) t) ->
  let L i t := emitted_edge Single the_unit the_table the_scale fst i (clock t) in
  let U i t := emitted_edge Single the_unit the_table the_scale snd i (clock t) in
  (* P1 *) (forall i t, (i < 2)%nat -> L i t + Q2R (min_width the_task) <= U i t) /\
  (* P2 *) (forall i, (i < 2)%nat -> L i 0 < real_at (initial_state the_task) i < U i 0 /\ in_box L U (Tube.initial_set the_task) i 0) /\
  (* P3 *) (forall i t, (i < 2)%nat -> in_box L U (state_space the_task) i t) /\
  (* P4 *) (forall o t, In o (unsafe_sets the_task) -> separated 2 (Q2R (clearance the_task)) o (fun i => L i t) (fun i => U i t)) /\
  (* P5 *) (forall i t, (i < 2)%nat -> Q2R (t_c the_task) <= t -> in_box L U (target_set the_task) i t) /\
  (* P3 and P5 where half-spaces cut *)
  (forall t x, (forall i, (i < 2)%nat -> L i t <= x i <= U i t) ->
    within_half_spaces 2 (state_half_spaces the_task) x /\ (Q2R (t_c the_task) <= t -> within_half_spaces 2 (target_half_spaces the_task) x)).
Proof.
  exact (emitted_tube_sound Single the_unit the_error the_search the_task the_table the_step_maxima the_scale the_time_error
           tube_checked slopes_checked rounding_checked).
Qed.


Definition theorems := (emitted_tube).
Print Assumptions theorems.
