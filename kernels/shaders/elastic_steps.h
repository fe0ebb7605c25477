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

// Sites along an axis that a step sums up; a dispatch of several steps has so many at most, on levels of so
// many sites with what lies around them.
#define ELASTIC_BLOCK 4
#define ELASTIC_TOGETHER_STEPS 20
#define ELASTIC_COARSE_SITES 2720

// Bindings, as backends/device/device.hpp has kinds of them: four that are stored to, words, and what is
// fetched.
#define ELASTIC_STORED 0
#define ELASTIC_STORED_SECOND 1
#define ELASTIC_STORED_THIRD 2
#define ELASTIC_KEPT 3
#define ELASTIC_TOUCHED 4
#define ELASTIC_FROM 7
#define ELASTIC_SECOND 8
#define ELASTIC_THIRD 9
#define ELASTIC_MOMENTS 10
#define ELASTIC_RESPONSE 11
#define ELASTIC_MATRICES 12
#define ELASTIC_INVERSE 13
