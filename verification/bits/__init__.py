"""Do the interpreter and the C code agree to the last bit? On this machine, and under emulation of others."""
