# SPDX-License-Identifier: BSD-3-Clause
"""Memory that is used where it may not be ends a program under scripts/robustness/guarded_memory.c, which says how."""
import os
import subprocess
import sys
import tempfile

PROGRAM = r"""
#include <math.h>
#include <stdlib.h>
int main(int argc, char** argv) {
  volatile double* x = malloc(3 * sizeof *x);
  volatile double* y = malloc(4 * sizeof *y);
  switch (argc > 1 ? argv[1][0] : 0) {
    case 'r': return y[4] > 0;        // reads behind a block that ends at the page
    case 'b': x[3] = 1; break;        // writes between a block and the page
    case 'f': x[-1] = 1; break;       // writes before a block
    case 't': free((void*)x); break;  // frees twice
    case 'u': return isnan(x[1]) ? 0 : 1;
    case 'o': free((void*)y); return isnan(y[0]) ? 0 : 1;
  }
  x = realloc((void*)x, 30000);
  free((void*)x), free((void*)y);
  return 0;
}
"""
SAID = {"read": "byte 32 of a block of 32 bytes was used", "behind": "written behind a block", "front": "written before a block",
        "twice": "freed twice", "unset": None, "old": None, "nothing": None}

with tempfile.TemporaryDirectory() as folder:
    library, program = os.path.join(folder, "guarded_memory.so"), os.path.join(folder, "program")
    subprocess.run(["cc", "-O2", "-fPIC", "-fno-builtin", "-shared", "-o", library, os.path.join(sys.argv[1], "scripts/robustness/guarded_memory.c")], check=True)
    subprocess.run(["cc", "-O0", "-w", "-x", "c", "-o", program, "-"], input=PROGRAM, text=True, check=True)
    for kind, said in SAID.items():
        run = subprocess.run([program, kind], env={**os.environ, "LD_PRELOAD": library}, capture_output=True, text=True, timeout=60)
        if said is None:
            assert run.returncode == 0 and run.stderr == "", (kind, run.returncode, run.stderr)
        else:
            assert run.returncode < 0 and said in run.stderr, (kind, run.returncode, run.stderr)
