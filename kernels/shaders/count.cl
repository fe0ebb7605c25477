// Adds to `changed` the number of sites at which two displacements differ in value (-0 equals 0), a group per row.
// `origin` and `plane` as sweep.cl has them.

typedef struct {
  int width;
  uint origin;
  uint plane;
} CountedSites;

kernel void count_changes(global const float* displacement, global const float* before, global uint* changed,
                          CountedSites p) {
  size_t start = (size_t)p.origin + get_group_id(0) * (size_t)p.width;
  uint differing = 0;
  for (int x = get_local_id(0); x < p.width; x += get_local_size(0)) {
    size_t site = start + (size_t)x;
    differing += (displacement[site] != before[site]) | (displacement[p.plane + site] != before[p.plane + site]);
  }
  if (differing > 0) {
    atomic_add(changed, differing);
  }
}
