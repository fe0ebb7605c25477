// What a device does to all sites of a level in one go: steps of elastic.comp, elastic.frag and elastic.cl,
// and of backends/session/elastic_steps.hpp, which says what each reads and writes.

#define ELASTIC_RELAX 0
#define ELASTIC_RELAX_FROM_ZERO 1
#define ELASTIC_RESIDUAL 2
#define ELASTIC_RESTRICT 3
#define ELASTIC_INTERPOLATE 4
#define ELASTIC_CORRECT 5
#define ELASTIC_SOLVE 6
#define ELASTIC_ADVANCE 7
#define ELASTIC_PRODUCTS 8
#define ELASTIC_SQUARES 9

// Sites beside each other that an invocation of elastic.comp has in relax and residual; groups of a list of
// sites side by side.
#define ELASTIC_COLUMNS 2
#define ELASTIC_LIST_GROUPS 32768

// Of elastic_coarse.comp: sites of an array, of which shared memory has three (32 KiB), and where they are
// not kept there; steps in a dispatch.
#define ELASTIC_SHARED_SITES 1360
#define ELASTIC_COARSE_SITES 2720
#define ELASTIC_COARSE_STEPS 24

// Bindings of both, as backends/device/device.hpp has kinds of them: four that are stored to, and what is
// fetched.
#define ELASTIC_STORED 0
#define ELASTIC_STORED_SECOND 1
#define ELASTIC_STORED_THIRD 2
#define ELASTIC_KEPT 3
#define ELASTIC_FROM 7
#define ELASTIC_SECOND 8
#define ELASTIC_THIRD 9
#define ELASTIC_MOMENTS 10
#define ELASTIC_MORE 11
#define ELASTIC_RESPONSE 12
#define ELASTIC_MATRICES 13
#define ELASTIC_INVERSE 14
#define ELASTIC_TOUCHED 15
