// Passes of levels.comp and levels.cl, and loops of loops.comp, loops.cl and passes.frag.

#define LEVEL_SAMPLE 0  // its moduli, targets and confidences at the sites of the full image
#define LEVEL_PROJECT 1 // the displacement that it begins with, from the level before
#define LEVEL_COUNT 2   // at how many sites two displacements differ in value (-0 equals 0)

#define LOOP_PROBE 0        // probe.inc
#define LOOP_COPY 1         // moves memory
#define LOOP_MULTIPLY_ADD 2 // calculates: nothing but multiply-adds, apart as the specification has them
