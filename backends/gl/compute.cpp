#include "backends/gl/compute.hpp"

#include "backends/coarse_levels.hpp"
#include "backends/gl/buffer_texture.hpp"
#include "backends/gl/ceilings.hpp"
#include "backends/gl/coarse_levels.hpp"
#include "backends/gl/context_session.hpp"
#include "backends/gl/interleave.hpp"
#include "backends/gl/tile_sweeps.hpp"

#include <fmt/format.h>
#include <shaders/count_compute.hpp>
#include <shaders/project_compute.hpp>
#include <shaders/sample_compute.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench::gl {

namespace {

constexpr Version required{4, 3};

/// As in the shaders' layout(binding = ..., location = ...).
constexpr GLenum image_unit = 0;
constexpr GLenum material_unit = 1;
constexpr GLenum observation_unit = 2;
constexpr GLenum curvature_unit = 3;
constexpr GLenum previous_unit = 1;
constexpr GLuint next_image_unit = 0;
constexpr GLuint table_binding = 0;
constexpr GLint dimension_location = 0;
constexpr GLint source_width_location = 1;

/// Of the shaders that visit each site once: groups of 64 along x.
constexpr int group_width = 64;

/// Levels with fewer sites are swept in a time in which no list can be kept.
constexpr std::size_t fewest_for_lists = std::size_t{64} * 64;

/// Sites that are updated before the host waits, so that no driver takes the work for hung.
constexpr double most_in_flight = 2e9;

/// What does not change during the sweeps of a level, on the device.
struct Constants {
  explicit Constants(const Api& api) : material(api), observation(api), curvature(api) {}

  void bind() const {
    material.bind(material_unit);
    observation.bind(observation_unit);
    curvature.bind(curvature_unit);
  }

  BufferTexture material;    ///< rg: modulus, 1 / modulus
  BufferTexture observation; ///< rg: target, ba: confidence
  BufferTexture curvature;   ///< rg: 1 / curvature; one texel where the rule needs none
};

/// A level of a pyramid that is not one of the coarse ones.
struct DeviceLevel {
  PyramidLevel plan;
  TileSweeps sweeps;
  Buffer sampled; ///< of sample.comp
  Buffer axes;    ///< of project.comp
};

/// Everything that lives in the context, so that it can be destroyed while the context is current.
class ComputeSweep {
public:
  /// Displacement there and back, observation, confidence.
  static constexpr double bytes_per_update = 8 + 8 + 16 + 8;
  static Ceilings ceilings(const Api& api) { return compute_ceilings(api); }
  /// OpenGL 4.3 guarantees 1024 invocations and 32 KiB of shared memory.
  static std::vector<int> coarse_groups() {
    static_assert(coarse_shared_bytes <= 32 * 1024);
    return {coarse_group_sizes.begin(), coarse_group_sizes.end()};
  }

  ComputeSweep(const Api& api, Work work)
      : gl_(api), work_(work), images_{BufferTexture(api), BufferTexture(api)}, constants_(api),
        sampled_(api), counter_(api), coarse_(api),
        count_program_(api, {{GL_COMPUTE_SHADER, std::string(sources::count_compute)}}) {}

  void load(const Level& level) {
    upload(level);
    sweeps_.emplace(gl_, programs_, level, list_tiles(level, level.extent, Alignment::corner),
                    keeps_lists(level, level.extent));
    gl_.Finish();
  }

  void write(const VectorField& displacement) {
    interleave<2>({displacement.x.data(), displacement.y.data()}, extent_.sites(), texels_);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    images_[current_].write(texels_);
    sweeps_->wake_all();
    gl_.Finish();
  }

  void step(int first, int sweeps) {
    constants_.bind();
    run(*sweeps_, extent_, first, sweeps);
    gl_.Finish();
  }

  /// `coarse_group` as SessionOptions has it.
  void load(const Pyramid& pyramid, int coarse_group) {
    const Level& full = *pyramid.full;
    upload(full);
    if (pyramid.levels.size() > 1) {
      prepare_sampling(full.extent);
    }
    coarse_.load(pyramid, coarse_group, work_ == Work::active);
    Level rules = without_fields(full);
    Extent above = coarse_.extent();
    for (const PyramidLevel& plan : std::span(pyramid.levels).subspan(coarse_.count())) {
      rules.strengths = plan.strengths;
      levels_.push_back({.plan = plan,
                         .sweeps = {gl_, programs_, rules, list_tiles(full, plan.extent, pyramid.alignment),
                                    keeps_lists(full, plan.extent)},
                         .sampled = Buffer(gl_),
                         .axes = Buffer(gl_)});
      if (plan.extent != full.extent) {
        fill(levels_.back().sampled, sampled_indices(plan.extent.width, full.extent.width, pyramid.alignment),
             sampled_indices(plan.extent.height, full.extent.height, pyramid.alignment));
      }
      if (above != Extent{}) {
        fill(levels_.back().axes, interpolations(above.width, plan.extent.width, pyramid.alignment),
             interpolations(above.height, plan.extent.height, pyramid.alignment));
      }
      above = plan.extent;
    }
    gl_.Finish();
  }

  void solve(const Session::Advance& advance) {
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    if (coarse_.count() > 0) {
      coarse_.solve(constants_.material, constants_.observation, images_[1 - current_]);
      current_ = 1 - current_;
    } else {
      texels_.assign(2 * levels_.front().plan.extent.sites(), 0.0F);
      images_[current_].write(texels_);
    }
    Extent above = coarse_.extent();
    double in_flight = coarse_.site_updates();
    for (DeviceLevel& level : levels_) {
      if (above != Extent{}) {
        project(above, level);
      }
      above = level.plan.extent;
      const bool is_full = level.plan.extent == extent_;
      if (!is_full) {
        sample(level);
      }
      (is_full ? constants_ : sampled_).bind();
      level.sweeps.wake_all();
      const auto sites = static_cast<double>(level.plan.extent.sites());
      const int at_once = static_cast<int>(std::clamp(most_in_flight / sites, 1.0, 1e6));
      for (int first = 0; first < level.plan.sweeps; first += at_once) {
        const int sweeps = std::min(at_once, level.plan.sweeps - first);
        run(level.sweeps, level.plan.extent, first, sweeps);
        in_flight += sites * sweeps;
        if (in_flight > most_in_flight) {
          gl_.Finish();
          advance(std::exchange(in_flight, 0.0));
        }
      }
    }
    gl_.Finish();
    advance(in_flight);
  }

  void read(VectorField& displacement) {
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    texels_.resize(2 * extent_.sites());
    images_[current_].read(texels_);
    for (std::size_t i = 0; i < extent_.sites(); ++i) {
      displacement.x[i] = texels_[2 * i];
      displacement.y[i] = texels_[2 * i + 1];
    }
  }

  std::int64_t changed() {
    GLuint count = 0;
    gl_.BindBuffer(GL_ATOMIC_COUNTER_BUFFER, counter_.name());
    gl_.BufferData(GL_ATOMIC_COUNTER_BUFFER, sizeof(count), &count, GL_DYNAMIC_READ);
    gl_.BindBufferBase(GL_ATOMIC_COUNTER_BUFFER, 0, counter_.name());
    count_program_.use();
    gl_.Uniform2i(dimension_location, extent_.width, extent_.height);
    images_[current_].bind(image_unit);
    images_[1 - current_].bind(previous_unit);
    dispatch(extent_);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.GetBufferSubData(GL_ATOMIC_COUNTER_BUFFER, 0, sizeof(count), &count);
    return count;
  }

private:
  void require_room(Extent extent) const {
    GLint texels = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    // The number of groups along y; core OpenGL guarantees 65535 and has no query without an index.
    constexpr int largest_height = 65535;
    if (extent.sites() > static_cast<std::size_t>(texels) || extent.height > largest_height) {
      throw TooLarge(
          fmt::format("the image is {} x {}, this device's buffer textures end at {} sites and {} rows",
                      extent.width, extent.height, texels, largest_height));
    }
  }

  [[nodiscard]] bool keeps_lists(const Level& level, Extent extent) const {
    return work_ == Work::active && changes_spread_by_contact(level) && extent.sites() >= fewest_for_lists;
  }

  /// The level itself and room for its displacement; forgets all that was loaded before.
  void upload(const Level& level) {
    require_room(level.extent);
    sweeps_.reset();
    levels_.clear();
    extent_ = level.extent;
    const std::size_t sites = extent_.sites();
    interleave<2>({level.modulus.values.data(), level.inverse_modulus.values.data()}, sites, texels_);
    constants_.material.allocate(GL_RG32F, 2 * sites * sizeof(GLfloat), texels_.data());
    interleave<4>(
        {level.target.x.data(), level.target.y.data(), level.confidence.x.data(), level.confidence.y.data()},
        sites, texels_);
    constants_.observation.allocate(GL_RGBA32F, 4 * sites * sizeof(GLfloat), texels_.data());
    if (needs_inverse_curvature(level.rule)) {
      interleave<2>({level.inverse_curvature.x.data(), level.inverse_curvature.y.data()}, sites, texels_);
      constants_.curvature.allocate(GL_RG32F, 2 * sites * sizeof(GLfloat), texels_.data());
    } else {
      constants_.curvature.allocate(GL_RG32F, 2 * sizeof(GLfloat), nullptr);
    }
    for (const BufferTexture& image : images_) {
      image.allocate(GL_RG32F, 2 * sites * sizeof(GLfloat), nullptr);
    }
  }

  /// Room for the largest of the coarse levels, and the programs that fill it.
  void prepare_sampling(Extent full) {
    sampled_.material.allocate(GL_RG32F, 2 * full.sites() * sizeof(GLfloat), nullptr);
    sampled_.observation.allocate(GL_RGBA32F, 4 * full.sites() * sizeof(GLfloat), nullptr);
    sampled_.curvature.allocate(GL_RG32F, 2 * sizeof(GLfloat), nullptr);
    if (!sample_program_) {
      sample_program_.emplace(gl_, std::initializer_list<Program::Stage>{
                                       {GL_COMPUTE_SHADER, std::string(sources::sample_compute)}});
      project_program_.emplace(gl_, std::initializer_list<Program::Stage>{
                                        {GL_COMPUTE_SHADER, assemble(sources::project_compute, "")}});
    }
  }

  template <typename Entry>
  void fill(const Buffer& buffer, std::vector<Entry> columns, const std::vector<Entry>& rows) const {
    columns.insert(columns.end(), rows.begin(), rows.end());
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.name());
    gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(columns.size() * sizeof(Entry)),
                   columns.data(), GL_STATIC_DRAW);
  }

  void sample(const DeviceLevel& level) const {
    sample_program_->use();
    gl_.Uniform2i(dimension_location, level.plan.extent.width, level.plan.extent.height);
    gl_.Uniform1i(source_width_location, extent_.width);
    constants_.material.bind(0);
    constants_.observation.bind(1);
    sampled_.material.bind_image(0, GL_RG32F);
    sampled_.observation.bind_image(1, GL_RGBA32F);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, table_binding, level.sampled.name());
    dispatch(level.plan.extent);
    gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  }

  void project(Extent above, const DeviceLevel& level) {
    project_program_->use();
    gl_.Uniform2i(dimension_location, level.plan.extent.width, level.plan.extent.height);
    gl_.Uniform1i(source_width_location, above.width);
    images_[current_].bind(image_unit);
    images_[1 - current_].bind_image(next_image_unit, GL_RG32F);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, table_binding, level.axes.name());
    dispatch(level.plan.extent);
    gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    current_ = 1 - current_;
  }

  /// The level's constants are bound.
  void run(TileSweeps& sweeps, Extent extent, int first, int count) {
    sweeps.bind(extent);
    for (int number = first; number < first + count; ++number) {
      images_[current_].bind(image_unit);
      images_[1 - current_].bind_image(next_image_unit, GL_RG32F);
      sweeps.sweep(number);
      current_ = 1 - current_;
    }
  }

  void dispatch(Extent extent) const {
    gl_.DispatchCompute(static_cast<GLuint>((extent.width + group_width - 1) / group_width),
                        static_cast<GLuint>(extent.height), 1);
  }

  const Api& gl_;
  Work work_;
  std::array<BufferTexture, 2> images_;
  Constants constants_;
  Constants sampled_; ///< of the coarse level that is swept
  Buffer counter_;
  CoarseLevels coarse_;
  Program count_program_;
  std::optional<Program> sample_program_;
  std::optional<Program> project_program_;
  TilePrograms programs_;
  std::optional<TileSweeps> sweeps_; ///< where load(level) was the last
  std::vector<DeviceLevel> levels_;  ///< after the coarse ones, where load(pyramid) was the last
  Extent extent_;
  std::size_t current_ = 0;
  std::vector<GLfloat> texels_; ///< interleaved staging, as long as what was uploaded or read last
};

} // namespace

std::unique_ptr<Backend> make_compute(std::unique_ptr<Platform> platform) {
  return std::make_unique<ContextBackend<ComputeSweep>>(
      "gl-compute", "GLSL 4.30 compute shader, OpenGL through EGL", std::move(platform), required);
}

} // namespace hdmbench::gl
