// For GLSL and C++: sides of a tile of kernels/sweep.vulkan.comp in sites.
#define TILE_WIDTH 32
#define TILE_HEIGHT 8
