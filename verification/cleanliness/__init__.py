"""Is the generated C clean? Warnings, sanitizers, valgrind, MISRA, what the object file holds, and its stack."""
