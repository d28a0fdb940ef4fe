"""What the flagship does on the flights, measured: false alarms, the paper's Fig. 4, the faults of its Table II; and what
the observers of paper 003 cost.

Each is a function that returns frozen data, and a command that prints or writes it:

    python -m verification.results.false_alarms
    python -m verification.results.fig4
    python -m verification.results.fault_table -o docs/fault_table.md
    python -m verification.results.horizon_operations
"""
