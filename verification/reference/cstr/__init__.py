"""Plain numpy estimators of paper 001 (Alessandri, Baglietto, Battistelli, Zavala) on its stirred tank reactor.

Independent of the sheets in saoflow/diagrams/cstr. Equation numbers are the paper's; `docs/corrections.md` lists what it
prints wrongly. Every quantity is without unit, as in the paper; the state is x = (concentration, temperature).
"""
