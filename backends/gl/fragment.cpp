#include "backends/gl/fragment.hpp"

#include "backends/gl/fragment_programs.hpp"
#include "backends/session/device_backend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <optional>

namespace hdmbench::gl {

namespace {

constexpr Version required{2, 1};

/// Throws DeviceError where a point cannot be as large as a tile.
void require_points(const Api& gl) {
  std::array<GLint, 2> range{};
  gl.GetIntegerv(GL_ALIASED_POINT_SIZE_RANGE, range.data());
  if (range[1] < FragmentLevel::tile_side) {
    throw DeviceError(fmt::format("glGetIntegerv: this device's points end at {} pixels, {} are needed",
                                  range[1], FragmentLevel::tile_side));
  }
}

/// Whether vertex shaders can fetch, and thereby leave tiles out. Where they cannot, every sweep is dense.
bool has_vertex_textures(const Api& gl) {
  GLint units = 0;
  gl.GetIntegerv(GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS, &units);
  return units > 0;
}

/// What a session has on its device. A pyramid is computed level by level.
class FragmentWork {
public:
  FragmentWork(const Context& context, Work work)
      : gl_(context.api()), quad_(gl_), count_framebuffer_(gl_), count_target_(gl_), query_(gl_),
        programs_(gl_), vertex_textures_(has_vertex_textures(gl_)),
        leaves_out_(work == Work::active && vertex_textures_) {
    require_points(gl_);
  }

  void load(const Level& level) {
    require_fits(level.extent);
    level_.reset(); // before the new one, so that both need not fit
    const bool is_volume = level.extent.axes() == 3;
    const Texels texels{.columns = level.rule == Rule::steps && vertex_textures_ && !is_volume ? 2 : 1};
    std::vector<GLfloat> second;
    if (texels.columns == 2) {
      pixels_ = interleaved({level.target[0], level.target[1], level.confidence[0], level.confidence[1]});
      second = interleaved_pairs(level.inverse_modulus.values, level.modulus.values, level.extent);
    } else if (is_volume) {
      pixels_ = interleaved({level.target[0], level.target[1], level.target[2], level.modulus.values});
      second = interleaved({level.confidence[0], level.confidence[1], level.confidence[2], {}});
    } else {
      pixels_ =
          interleaved({level.target[0], level.target[1], level.modulus.values, level.inverse_modulus.values});
      second = interleaved({level.confidence[0], level.confidence[1], level.inverse_curvature[0],
                            level.inverse_curvature[1]}); // empty where the rule needs none
    }
    level_.emplace(gl_, level, texels, pixels_.data(), second.data(), leaves_out(level));
    inverse_modulus_ = level.inverse_modulus.values;
    make_count_target();
    gl_.Finish();
  }

  void write(const VectorField& displacement) {
    FragmentLevel& level = *level_;
    if (level.texels.columns == 2) {
      pixels_ = interleaved_pairs(displacement[0], displacement[1], displacement.extent);
    } else if (displacement.extent.axes() == 3) {
      pixels_ = interleaved({displacement[0], displacement[1], displacement[2], inverse_modulus_});
    } else { // b is what thesis Tab. 6.2 leaves free
      pixels_ = interleaved({displacement[0], displacement[1], inverse_modulus_, {}});
    }
    level.now().upload(pixels_.data());
    level.wake_all();
    gl_.Finish();
  }

  void step(int first, int sweeps) {
    timer_([&] { sweep(*level_, first, sweeps); });
    gl_.Finish();
  }

  std::optional<double> device_seconds() { return timer_.device_seconds(); }

  void read(VectorField& displacement) {
    const Extent extent = displacement.extent;
    FragmentLevel& level = *level_;
    const Extent texels = level.texels.of(extent);
    pixels_.resize(4 * texels.sites());
    level.now().read(0, texels, pixels_.data());
    const auto pitch = 4 * static_cast<std::size_t>(texels.width);
    const auto step = 4 / static_cast<std::size_t>(level.texels.columns);
    std::size_t i = 0;
    for (std::size_t row = 0; row < pixels_.size(); row += pitch) {
      for (std::size_t at = row; at < row + step * static_cast<std::size_t>(extent.width); at += step) {
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          displacement[axis][i] = pixels_[at + axis];
        }
        ++i;
      }
    }
  }

  std::int64_t changed() {
    FragmentLevel& level = *level_;
    (void)programs_.pass(level.texels.columns == 2 ? "#define COUNTS\n#define PAIRS\n" : "#define COUNTS\n");
    level.now().bind(image_unit);
    level.other().bind(previous_unit);
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, count_framebuffer_.name());
    gl_.BeginQuery(GL_SAMPLES_PASSED, query_.name());
    for (int slice = 0; slice < level.header.extent.depth; ++slice) {
      quad_.draw(level.now().corner(slice), level.header.extent);
    }
    gl_.EndQuery(GL_SAMPLES_PASSED);
    GLuint passed = 0;
    gl_.GetQueryObjectuiv(query_.name(), GL_QUERY_RESULT, &passed);
    return passed;
  }

private:
  void require_fits(Extent extent) const {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    const Extent texture = texture_of(extent);
    if (texture.width > limit || texture.height > limit) {
      throw TooLarge(fmt::format("{}, this device's rectangle textures end at {} x {}",
                                 extent.axes() == 3
                                     ? fmt::format("the slices of {} take {}", extent.text(), texture.text())
                                     : "the image is " + extent.text(),
                                 limit, limit));
    }
  }

  /// Levels that are worth it. CPU time of a solution on llvmpipe, 50 sweeps a level: with 256 * 256 the
  /// stiff square of 300 x 300 takes 0.17 s and with this 0.09; circular 0.121 and 0.123, dense 0.117.
  [[nodiscard]] bool leaves_out(const Level& level) const {
    constexpr std::size_t worth_it = std::size_t{128} * 128;
    return leaves_out_ && level.extent.axes() == 2 && changes_spread_by_contact(level) &&
           level.extent.sites() >= worth_it;
  }

  void sweep(FragmentLevel& level, int first, int sweeps) {
    level.constants.second.bind(second_unit);
    if (level.constants.inputs) {
      level.constants.inputs->bind(inputs_unit);
    }
    if (level.constants.curvature) {
      level.constants.curvature->bind(curvature_unit);
    }
    std::vector<const FragmentPrograms::Sweep*> programs;
    for (const FragmentLevel::Draw& draw : level.draws) {
      programs.push_back(&programs_.sweep(level, draw));
    }
    for (int number = first; number < first + sweeps; ++number) {
      if (level.activity) {
        level.activity->awake.bind(awake_unit);
      }
      level.now().bind(image_unit);
      level.constants.observation.bind(observation_unit);
      level.other().draw_into();
      level.prepare_tiles(FragmentLevel::tile_side);
      for (std::size_t i = 0; i < programs.size(); ++i) {
        programs[i]->program.use();
        if (programs[i]->turn >= 0) {
          const SweepState turn = sweep_state(level.header, number);
          gl_.Uniform4f(programs[i]->turn, turn.colour, turn.strength, turn.number, turn.seed);
        }
        if (level.header.extent.axes() == 3) {
          draw_slices(level, programs[i]->slice);
        } else {
          level.draw_points(level.draws[i]);
        }
      }
      level.swap();
      if (level.activity && level.activity->is_due()) {
        find_awake(level);
      }
    }
  }

  void draw_slices(const FragmentLevel& level, GLint location) {
    for (int slice = 0; slice < level.header.extent.depth; ++slice) {
      gl_.Uniform1f(location, static_cast<GLfloat>(slice));
      quad_.draw(level.constants.observation.corner(slice), level.header.extent);
    }
  }

  /// Which tiles the next sweep has to visit. Those that slept have not touched their cells.
  void find_awake(FragmentLevel& level) {
    programs_.use_cells(level);
    level.now().bind(image_unit);
    level.other().bind(previous_unit);
    level.activity->cells.draw_into();
    level.prepare_tiles(FragmentLevel::cells_along_a_tile);
    level.draw_all_tiles(FragmentLevel::cells_along_a_tile);
    (void)programs_.pass(fmt::format("#define CELLS {}\n", FragmentLevel::cells_along_a_tile));
    level.activity->cells.bind(image_unit);
    level.activity->awake.draw_into();
    quad_.draw({}, level.grid);
  }

  void make_count_target() {
    const Extent extent = texture_of(level_->header.extent);
    gl_.BindRenderbufferEXT(GL_RENDERBUFFER_EXT, count_target_.name());
    gl_.RenderbufferStorageEXT(GL_RENDERBUFFER_EXT, GL_RGBA8, extent.width, extent.height);
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, count_framebuffer_.name());
    gl_.FramebufferRenderbufferEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_RENDERBUFFER_EXT,
                                   count_target_.name());
    require_complete(gl_);
  }

  const Api& gl_;
  Quad quad_;
  std::optional<FragmentLevel> level_; ///< where one is loaded
  Framebuffer count_framebuffer_;
  Renderbuffer count_target_;
  Query query_;
  Timer timer_{gl_};
  FragmentPrograms programs_;
  bool vertex_textures_; ///< vertex shaders can fetch: not a device of the thesis's generation
  bool leaves_out_;      ///< what cannot change
  std::vector<float> inverse_modulus_;
  std::vector<GLfloat> pixels_; ///< RGBA staging
};

/// Quads into float rectangle textures, texel after texel in rows.
class FragmentLoops final : public Loops {
public:
  explicit FragmentLoops(const Context& context) : gl_(context.api()), quad_(gl_), programs_(gl_) {}

private:
  static constexpr int widest = 4096;

  /// Texels a side of a texture, as a power of two.
  [[nodiscard]] int longest_side() const {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    return static_cast<int>(std::bit_floor(static_cast<unsigned>(limit)));
  }
  [[nodiscard]] int most_columns() const { return std::min(widest, longest_side()); }
  std::size_t most_texels() const override {
    return static_cast<std::size_t>(most_columns()) * static_cast<std::size_t>(longest_side());
  }
  void load(std::span<const float> source, std::size_t texels) override {
    const auto count = static_cast<int>(texels);
    const auto fetched = static_cast<int>(source.size() / 4) / count; // texels for each
    const int columns = std::gcd(count, most_columns() / fetched);
    source_.emplace(gl_, Extent{fetched * columns, count / columns}, source.data());
    targets_.clear();
    for (int i = 0; i < 2; ++i) {
      targets_.emplace_back(gl_, Extent{columns, count / columns}, nullptr).make_drawable();
    }
  }
  /// Into both targets in turn, as sweeps are: of several opaque drawings into one, a driver that draws tile
  /// by tile does only the last.
  void run(int loop, std::size_t texels, int times) override {
    (void)programs_.pass(fmt::format("#define LOOP {}\n", loop));
    source_->bind(image_unit);
    for (int i = 0; i < times; ++i) {
      targets_[static_cast<std::size_t>(i % 2)].draw_into();
      quad_.draw({}, rows_of(texels));
    }
    gl_.Finish();
  }
  std::vector<float> result(std::size_t texels) override {
    std::vector<float> values(4 * texels);
    const Extent rows = rows_of(texels);
    gl_.ReadPixels(0, 0, rows.width, rows.height, GL_RGBA, GL_FLOAT, values.data());
    return values;
  }

  [[nodiscard]] Extent rows_of(std::size_t texels) const {
    const int columns = targets_.front().extent().width;
    return {columns, static_cast<int>(texels) / columns};
  }

  const Api& gl_;
  Quad quad_;
  FragmentPrograms programs_;
  std::optional<Target> source_;
  std::vector<Target> targets_;
};

/// What DeviceBackend opens. Texels are those of two sites; of one site they have more bytes.
struct FragmentSource {
  std::unique_ptr<Platform> platform;

  [[nodiscard]] std::vector<Device> devices() const { return platform->devices(required); }
  [[nodiscard]] std::unique_ptr<Session> session(std::size_t index, const SessionOptions& options) const {
    return std::make_unique<LevelSession<Context, FragmentWork>>(platform->open(index, required),
                                                                 options.work);
  }
  [[nodiscard]] std::unique_ptr<ElasticSession> elastic(std::string name, std::size_t index,
                                                        const SessionOptions& /*options*/) const {
    return make_elastic_fragment(std::move(name), platform->open(index, required));
  }
  [[nodiscard]] OnDevice<Context, FragmentLoops> loops(std::size_t index) const {
    return OnDevice<Context, FragmentLoops>(platform->open(index, required));
  }
};

} // namespace

std::unique_ptr<Backend> make_fragment(std::string_view name, std::string_view description,
                                       std::unique_ptr<Platform> platform) {
  return std::make_unique<DeviceBackend<FragmentSource>>(
      DeviceBackendName{std::string(name), std::string(description), "GLSL 1.20, fragments"},
      FragmentSource{std::move(platform)});
}

} // namespace hdmbench::gl
