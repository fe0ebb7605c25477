// For GLSL and C++: sides of a tile of kernels/shaders/sweep.vulkan.comp in sites. By CPU time on lavapipe,
// one run each on a busy machine: 16 x 16 is a sixth faster at 300 x 300 and 13 to 21% slower at 1200 x 1200.
#define TILE_WIDTH 32
#define TILE_HEIGHT 16
