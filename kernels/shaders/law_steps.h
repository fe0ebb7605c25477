// What a device does about laws of large strains: steps of laws.h, as laws.comp and laws.cl have them and
// backends/session/laws_on_device.cpp asks for them.

#define LAW_CELLS 0
#define LAW_SITES 1
#define LAW_LEAST 2

// Bits of a site: which components are prescribed, x in the lowest, and whether the cell that begins there is
// looked at for what it has kept.
#define LAW_COUNTS 3

// Bindings, as backends/device/device.hpp has kinds of them.
#define LAW_STORED 0
#define LAW_SITE_BITS 4
#define LAW_SHARES 5
#define LAW_LEAST_OF_ITEMS 6
#define LAW_DISPLACEMENT 7
#define LAW_TISSUE 8
#define LAW_FORCES 9
#define LAW_FIBRES 10
