// What a device does to all sites of a level in one go: steps of elastic.comp, elastic.frag and elastic.cl, and of
// backends/shared/elastic_device.hpp, which says what each reads and writes.

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

// Of elastic.comp: invocations of a group, along x; the sites of one invocation of relax and residual.
#define ELASTIC_GROUP 32
#define ELASTIC_COLUMNS 2
#define ELASTIC_ROWS 16
