"""Plain numpy references of the estimator sheets, to be read beside paper 004.

`cmhe_fte`, `umhe_fte` and `ekf_fte` each offer `initial_state(tuning)`, `step(state, inputs, tuning)` and
`run(recording)`. The road of a frame: `inputs`, `conditioning`, `residuals` (Step 1), `fusion` (Step 2),
`linearisation`, `interior_point` or `unconstrained`, `search_direction` (Step 3), around `estimator.State`;
`ekf_fte` has its filter beside them.
"""
