// Preloaded where leaks are looked for: what a library has lost can be told by its name only while it is
// loaded.

extern "C" int dlclose(void* /*library*/) {
  return 0;
}
