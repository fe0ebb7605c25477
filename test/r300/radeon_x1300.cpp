// A Radeon X1300 that is not there.
//
// Mesa reaches a graphics card through libdrm. The functions below stand in for libdrm's, because the dynamic
// linker finds an executable's own symbols first (ENABLE_EXPORTS), and answer as the kernel's radeon driver
// would for the thesis's card. Memory is real, command streams are accepted and dropped. What happens on the
// CPU, the compilation of shaders above all, is Mesa's own r300 driver at work; what a shader computes is
// never known.

#include <radeon_drm.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drm.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <mutex>
#include <string>

namespace {

constexpr std::uint16_t vendor_id = 0x1002; // ATI
constexpr std::uint16_t device_id = 0x7142; // RV515, sold as Radeon X1300 and X1550
constexpr std::uint64_t memory_size = 256U << 20U;

/// The card: a file whose pages are its memory. Never destroyed, as drivers leave threads behind.
class Card {
public:
  Card() : file_(memfd_create("radeon", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(file_)) {
    // Sparse, and larger than the card: memory is not given out twice. A failure shows when it is opened or
    // mapped.
    if (ftruncate(file_, static_cast<off_t>(64 * memory_size)) != 0) {
      path_.clear();
    }
    nodes_[DRM_NODE_RENDER] = path_.data();
    device_.nodes = nodes_.data();
    device_.available_nodes = 1 << DRM_NODE_RENDER;
    device_.bustype = DRM_BUS_PCI;
    device_.businfo.pci = &bus_;
    device_.deviceinfo.pci = &identity_;
  }

  [[nodiscard]] drmDevicePtr device() { return &device_; }

  /// A buffer's handle is the number of its first page, so that a handle says where its memory is.
  [[nodiscard]] std::uint32_t allocate(std::uint64_t size) {
    const std::scoped_lock lock(mutex_);
    const std::uint32_t handle = next_page_;
    next_page_ += static_cast<std::uint32_t>((size + page - 1) / page);
    return handle;
  }
  [[nodiscard]] static std::uint64_t offset_of(std::uint32_t handle) { return handle * page; }

private:
  static constexpr std::uint64_t page = 4096;

  int file_;
  std::string path_;
  std::array<char*, DRM_NODE_MAX> nodes_{};
  drmPciBusInfo bus_{.domain = 0, .bus = 1, .dev = 0, .func = 0};
  drmPciDeviceInfo identity_{vendor_id, device_id, vendor_id, device_id, 0};
  drmDevice device_{};
  std::mutex mutex_;
  std::uint32_t next_page_ = 1; // handle 0 is none
};

Card& card() {
  static Card* const only = new Card;
  return *only;
}

/// What DRM_RADEON_INFO says; what is not listed is unknown, as to an old kernel.
int answer(const drm_radeon_info& info) {
  std::uint32_t value = 0;
  switch (info.request) {
  case RADEON_INFO_DEVICE_ID:
    value = device_id;
    break;
  case RADEON_INFO_NUM_GB_PIPES:
  case RADEON_INFO_NUM_Z_PIPES:
    value = 1;
    break;
  case RADEON_INFO_RING_WORKING: // the video decoder's
  case RADEON_INFO_GPU_RESET_COUNTER:
    break;
  default:
    return -EINVAL;
  }
  *reinterpret_cast<std::uint32_t*>(static_cast<std::uintptr_t>(info.value)) = value;
  return 0;
}

template <typename Request>
Request& as(void* data) {
  return *static_cast<Request*>(data);
}

} // namespace

extern "C" {

int drmGetDevices2(std::uint32_t, drmDevicePtr devices[], int maximum) {
  if (devices != nullptr && maximum > 0) {
    devices[0] = card().device();
  }
  return 1;
}

int drmGetDevice2(int, std::uint32_t, drmDevicePtr* device) {
  *device = card().device();
  return 0;
}

void drmFreeDevice(drmDevicePtr*) {}

void drmFreeDevices(drmDevicePtr[], int) {}

int drmDevicesEqual(drmDevicePtr a, drmDevicePtr b) {
  return a == b ? 1 : 0;
}

int drmGetNodeTypeFromFd(int) {
  return DRM_NODE_RENDER;
}

drmVersionPtr drmGetVersion(int) {
  static std::string name = "radeon";
  static std::string none;
  static drmVersion version{2, 50, 0, 6, name.data(), 0, none.data(), 0, none.data()};
  return &version;
}

void drmFreeVersion(drmVersionPtr) {}

int drmGetCap(int, std::uint64_t, std::uint64_t* value) {
  *value = 0;
  return -EINVAL;
}

int drmIoctl(int, unsigned long, void*) {
  return 0;
}

int drmCommandWrite(int, unsigned long, void*, unsigned long) {
  return 0;
}

int drmCommandWriteRead(int, unsigned long command, void* data, unsigned long) {
  switch (command) {
  case DRM_RADEON_INFO:
    return answer(as<drm_radeon_info>(data));
  case DRM_RADEON_GEM_INFO:
    as<drm_radeon_gem_info>(data) = {memory_size, memory_size, memory_size};
    return 0;
  case DRM_RADEON_GEM_CREATE:
    as<drm_radeon_gem_create>(data).handle = card().allocate(as<drm_radeon_gem_create>(data).size);
    return 0;
  case DRM_RADEON_GEM_MMAP:
    as<drm_radeon_gem_mmap>(data).addr_ptr = Card::offset_of(as<drm_radeon_gem_mmap>(data).handle);
    return 0;
  case DRM_RADEON_GEM_BUSY:
  case DRM_RADEON_GEM_SET_TILING:
  case DRM_RADEON_GEM_GET_TILING:
  case DRM_RADEON_CS:
    return 0;
  default:
    return -EINVAL;
  }
}

} // extern "C"
