// Which tiles the next sweep has to visit: those that see a change of this one. The includer supplies, after tile.glsl,
// the storage buffers
//
//   uint visited[]   per tile the last sweep that put it on a list, by its number
//   uint classes[]   per tile its class
//   uint tiles[]     the lists: all tiles by class, and as much again for each of two lists in turn
//   uint arguments[] the same three times, per class: groups along x, y and z, number of tiles
//
// and CLASSES, how many there are. Nothing waits for anything: atomicExchange decides who appends a tile, once.

const uint argument_words = 4u;
const uint most_groups = 65535u; // what every device can dispatch along x; groups take several tiles beyond

// Puts on the lists of `set`, 1 or 2, what sweep_tile() said, for sweep `number`.
void wake(ivec2 tile, int seen_from, ivec2 size, uint set, uint number, uint first[CLASSES]) {
  for (int bit = 0; bit < 9 && (seen_from >> bit) != 0; ++bit) {
    ivec2 other = tile + ivec2(bit % 3 - 1, bit / 3 - 1);
    bool inside = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size));
    if (inside && ((seen_from >> bit) & 1) != 0) {
      int index = other.y * size.x + other.x;
      if (atomicExchange(visited[index], number) != number) {
        uint kind = classes[index];
        uint argument = (set * uint(CLASSES) + kind) * argument_words;
        uint slot = atomicAdd(arguments[argument + 3u], 1u);
        tiles[set * uint(size.x * size.y) + first[kind] + slot] = uint(index);
        if (slot < most_groups) {
          atomicAdd(arguments[argument], 1u);
        }
      }
    }
  }
}
