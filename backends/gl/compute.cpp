#include "backends/gl/compute.hpp"

#include "backends/gl/arithmetic.hpp"
#include "backends/gl/buffer_texture.hpp"
#include "backends/gl/ceilings.hpp"
#include "backends/gl/coarse_levels.hpp"
#include "backends/gl/context_session.hpp"
#include "backends/gl/elastic_compute.hpp"
#include "backends/gl/interleave.hpp"
#include "backends/gl/tile_sweeps.hpp"
#include "backends/shared/coarse_levels.hpp"
#include "backends/shared/input_texels.hpp"
#include "backends/shared/resampling_entries.hpp"
#include "backends/shared/shader_bindings.hpp"

#include <fmt/format.h>
#include <shaders/count_compute.hpp>
#include <shaders/project_compute.hpp>
#include <shaders/sample_compute.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench::gl {

namespace {

constexpr Version required{4, 3};

/// Image units where shader_bindings.hpp has none for OpenGL.
constexpr GLuint swept_image_unit = 0; // of sweep.comp
constexpr GLuint sampled_material_unit = 5;
constexpr GLuint sampled_observation_unit = 6;

/// Locations of count.comp and resampling.glsl.
constexpr GLint width_location = 0;
constexpr GLint from_width_location = 1;
constexpr GLint first_column_location = 2;
constexpr GLint first_row_location = 3;

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
    material.bind(binding::material);
    observation.bind(binding::observation);
    curvature.bind(binding::inverse_curvature);
  }

  BufferTexture material;    ///< rg: modulus, 1 / modulus
  BufferTexture observation; ///< rg: target, ba: confidence
  BufferTexture curvature;   ///< rg: 1 / curvature; one texel where the rule needs none
};

/// A level of a pyramid that is not one of the coarse ones.
struct DeviceLevel {
  PyramidLevel plan;
  TileSweeps sweeps;
  GLint first_column = 0; ///< of its entries
};

/// Everything that lives in the context, so that it can be destroyed while the context is current.
class ComputeSweep {
public:
  static double bytes_per_update(SiteKind kind) { return hdmbench::bytes_per_update(kind, classes_inside); }
  static Ceilings ceilings(const Api& api) { return compute_ceilings(api); }
  static std::unique_ptr<ElasticDevice> elastic(std::unique_ptr<Context> context, bool is_software) {
    return make_elastic_compute(std::move(context), is_software);
  }
  static constexpr std::string_view language = "GLSL 4.30, compute";
  static std::vector<float> evaluate(const Api& api, std::span<const ArithmeticCase> cases) {
    return evaluate_in_compute(api, cases);
  }
  /// OpenGL 4.3 guarantees 1024 invocations and 32 KiB of shared memory.
  static Variants variants(bool is_software) {
    static_assert(coarse_shared_bytes <= 32 * 1024);
    return coarse_variants(1024, is_software);
  }
  static Variants shapes() { return sweep_variants(); }

  ComputeSweep(const Api& api, Work work)
      : gl_(api), work_(work), images_{BufferTexture(api), BufferTexture(api)}, constants_(api), inputs_(api),
        sampled_(api), entries_(api), counter_(api), coarse_(api),
        count_program_(api, {{GL_COMPUTE_SHADER, assemble(sources::count_compute, "")}}) {}

  /// `shape` of sweep_shapes.
  void load(const Level& level, std::size_t shape) {
    require_room(level.extent, 0);
    upload(level);
    upload(InputTexels(level));
    const SweepShape& tiles = sweep_shapes.at(shape);
    sweeps_.emplace(gl_, programs_, level, list_tiles(level, level.extent, Alignment::corner, tiles.tile),
                    tiles, keeps_lists(level, level.extent), 0);
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

  /// `coarse_group` of coarse_groups, `shape` of sweep_shapes.
  void load(const Pyramid& pyramid, int coarse_group, std::size_t shape) {
    const SweepShape& tiles = sweep_shapes.at(shape);
    const Level& full = *pyramid.full;
    const ResamplingEntries entries(pyramid);
    require_room(full.extent, entries.texels.size());
    upload(full);
    const InputTexels inputs(pyramid);
    upload(inputs);
    if (pyramid.levels.size() > 1) {
      prepare_sampling(full.extent, entries);
    }
    coarse_.load(pyramid, entries, coarse_group, work_ == Work::active);
    Level rules = without_fields(full);
    for (std::size_t i = coarse_.count(); i < pyramid.levels.size(); ++i) {
      const PyramidLevel& plan = pyramid.levels[i];
      rules.strengths = plan.strengths;
      levels_.push_back(
          {.plan = plan,
           .sweeps = {gl_, programs_, rules, list_tiles(full, plan.extent, pyramid.alignment, tiles.tile),
                      tiles, keeps_lists(full, plan.extent), inputs.first[i]},
           .first_column = entries.begins[i]});
    }
    gl_.Finish();
  }

  void solve(const Session::Advance& advance) {
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    if (coarse_.count() > 0) {
      constants_.bind();
      inputs_.bind(binding::inputs);
      entries_.bind(binding::entries);
      images_[1 - current_].bind_image(binding::improved, GL_RG32F);
      coarse_.solve();
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
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, counter_.name());
    gl_.BufferData(GL_SHADER_STORAGE_BUFFER, sizeof(count), &count, GL_DYNAMIC_READ);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding::counter, counter_.name());
    count_program_.use();
    gl_.Uniform1i(width_location, extent_.width);
    images_[current_].bind(binding::displacement);
    images_[1 - current_].bind_image(binding::improved, GL_RG32F, GL_READ_ONLY);
    dispatch(extent_);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof(count), &count);
    return count;
  }

private:
  /// For an image and the entries of its pyramid.
  void require_room(Extent extent, std::size_t entries) const {
    GLint texels = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    // The number of groups along y; core OpenGL guarantees 65535 and has no query without an index.
    constexpr int largest_height = 65535;
    if (std::max(extent.sites(), entries) > static_cast<std::size_t>(texels) ||
        extent.height > largest_height) {
      throw TooLarge(
          fmt::format("the image is {} x {}, this device's buffer textures end at {} sites and {} rows",
                      extent.width, extent.height, texels, largest_height));
    }
  }

  [[nodiscard]] bool keeps_lists(const Level& level, Extent extent) const {
    return work_ == Work::active && changes_spread_by_contact(level) && extent.sites() >= fewest_for_lists;
  }

  void upload(const InputTexels& inputs) {
    interleave<4>(
        {inputs.planes[0].data(), inputs.planes[1].data(), inputs.planes[2].data(), inputs.planes[3].data()},
        inputs.count(), texels_);
    texels_.resize(std::max<std::size_t>(texels_.size(), 4)); // one texel for an energy without any
    inputs_.allocate(GL_RGBA32F, texels_.size() * sizeof(GLfloat), texels_.data());
  }

  /// The level itself and room for its displacement; forgets all that was loaded before.
  void upload(const Level& level) {
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

  /// Room for the largest of the coarse levels, and what fills it.
  void prepare_sampling(Extent full, const ResamplingEntries& entries) {
    entries_.allocate(GL_RGBA32F, entries.texels.size() * sizeof(entries.texels.front()),
                      entries.texels.front().data());
    sampled_.material.allocate(GL_RG32F, 2 * full.sites() * sizeof(GLfloat), nullptr);
    sampled_.observation.allocate(GL_RGBA32F, 4 * full.sites() * sizeof(GLfloat), nullptr);
    sampled_.curvature.allocate(GL_RG32F, 2 * sizeof(GLfloat), nullptr);
    if (!sample_program_) {
      sample_program_.emplace(gl_, std::initializer_list<Program::Stage>{
                                       {GL_COMPUTE_SHADER, assemble(sources::sample_compute, "")}});
      project_program_.emplace(gl_, std::initializer_list<Program::Stage>{
                                        {GL_COMPUTE_SHADER, assemble(sources::project_compute, "")}});
    }
  }

  void sample(const DeviceLevel& level) const {
    constants_.bind();
    sampled_.material.bind_image(sampled_material_unit, GL_RG32F);
    sampled_.observation.bind_image(sampled_observation_unit, GL_RGBA32F);
    resample(*sample_program_, extent_, level);
  }

  void project(Extent above, const DeviceLevel& level) {
    images_[current_].bind(binding::displacement);
    images_[1 - current_].bind_image(binding::improved, GL_RG32F);
    resample(*project_program_, above, level);
    current_ = 1 - current_;
  }

  void resample(const Program& program, Extent from, const DeviceLevel& level) const {
    const Extent extent = level.plan.extent;
    program.use();
    gl_.Uniform1i(width_location, extent.width);
    gl_.Uniform1i(from_width_location, from.width);
    gl_.Uniform1i(first_column_location, level.first_column);
    gl_.Uniform1i(first_row_location, level.first_column + extent.width);
    entries_.bind(binding::entries);
    dispatch(extent);
    gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  }

  /// The level's constants are bound.
  void run(TileSweeps& sweeps, Extent extent, int first, int count) {
    sweeps.bind(extent);
    inputs_.bind(binding::inputs);
    for (int number = first; number < first + count; ++number) {
      images_[current_].bind(binding::displacement);
      images_[1 - current_].bind_image(swept_image_unit, GL_RG32F);
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
  BufferTexture inputs_;  ///< InputTexels
  Constants sampled_;     ///< of the coarse level that is swept
  BufferTexture entries_; ///< of a pyramid's levels
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
