#include "backends/gl/fragment.hpp"

#include "backends/gl/arithmetic.hpp"
#include "backends/gl/ceilings.hpp"
#include "backends/gl/context_session.hpp"
#include "backends/gl/elastic_fragment.hpp"
#include "backends/gl/fragment_level.hpp"
#include "backends/gl/fragment_programs.hpp"
#include "backends/gl/interleave.hpp"
#include "backends/shared/resampling_entries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

/// sample.frag's and project.frag's table of a level, whose entries begin at `first`: row 0 its columns, row
/// 1 its rows.
Target entry_table(const Api& gl, Extent extent, const std::array<float, 4>* first) {
  const Extent table{std::max(extent.width, extent.height), 2};
  std::vector<std::array<float, 4>> texels(table.sites());
  std::copy_n(first, extent.width, texels.begin());
  std::copy_n(first + extent.width, extent.height, texels.begin() + table.width);
  return {gl, table, texels.front().data()};
}

/// Everything that lives in the context, so that it can be destroyed while the context is current.
class FragmentSweep {
public:
  /// With texels of two sites; with texels of one it is more.
  static double bytes_per_update(SiteKind kind) { return hdmbench::bytes_per_update(kind, classes_inside); }
  static Ceilings ceilings(const Api& api) { return fragment_ceilings(api); }
  static std::unique_ptr<ElasticDevice> elastic(std::unique_ptr<Context> context) {
    return make_elastic_fragment(std::move(context));
  }
  static constexpr std::string_view language = "GLSL 1.20, fragments";
  static std::vector<float> evaluate(const Api& api, std::span<const ArithmeticCase> cases) {
    return evaluate_in_fragments(api, cases);
  }

  FragmentSweep(const Api& api, Work work)
      : gl_(api), count_framebuffer_(api), count_target_(api), query_(api), programs_(api),
        vertex_textures_(has_vertex_textures(api)), leaves_out_(work == Work::active && vertex_textures_) {
    require_points(api);
  }

  void load(const Level& level) {
    require_fits(level.extent);
    levels_.clear();
    tables_.clear();
    add_full_level(level, without_fields(level));
    inverse_modulus_ = level.inverse_modulus.values;
    make_count_target();
    gl_.Finish();
  }

  void load(const Pyramid& pyramid) {
    const Level& full = *pyramid.full;
    require_fits(full.extent);
    levels_.clear();
    tables_.clear();
    inverse_modulus_.clear();
    pyramid_sweeps_.clear();
    const ResamplingEntries entries(pyramid);
    for (const PyramidLevel& part : pyramid.levels) {
      Level header = without_fields(full);
      header.extent = part.extent;
      header.strengths = part.strengths;
      pyramid_sweeps_.push_back(part.sweeps);
      const auto first = static_cast<std::size_t>(entries.begins[tables_.size()]);
      tables_.push_back(entry_table(gl_, part.extent, &entries.texels[first]));
      if (&part == &pyramid.levels.back()) {
        add_full_level(full, std::move(header));
      } else {
        const Extent extent = part.extent;
        levels_.emplace_back(gl_, std::move(header), full, pyramid.alignment, texels_of(full), nullptr,
                             nullptr, leaves_out(full, extent));
      }
    }
    sample_levels();
    make_count_target();
    gl_.Finish();
  }

  void write(const VectorField& displacement) {
    FragmentLevel& level = levels_.back();
    if (level.texels.columns == 2) {
      interleave_pairs(displacement.x, displacement.y, displacement.extent, pixels_);
    } else { // b is what thesis Tab. 6.2 leaves free
      interleave<4>({displacement.x.data(), displacement.y.data(), inverse_modulus_.data(), nullptr},
                    displacement.extent.sites(), pixels_);
    }
    level.now().upload(pixels_.data());
    level.wake_all();
    gl_.Finish();
  }

  void step(int first, int sweeps) {
    sweep(levels_.back(), first, sweeps);
    gl_.Finish();
  }

  void solve(const Session::Advance& advance) {
    const std::array<GLfloat, 4> null_field{};
    const Target start(gl_, {1, 1}, null_field.data());
    const Target* before = &start;
    double site_updates = 0.0;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      FragmentLevel& level = levels_[i];
      level.bind_vertices();
      project(*before, tables_[i], level);
      level.wake_all();
      sweep(level, 0, pyramid_sweeps_[i]);
      before = &level.now();
      site_updates += static_cast<double>(level.header.extent.sites()) * pyramid_sweeps_[i];
    }
    gl_.Finish();
    advance(site_updates);
  }

  void read(VectorField& displacement) {
    const Extent extent = displacement.extent;
    FragmentLevel& level = levels_.back();
    const Extent texels = level.texels.of(extent);
    pixels_.resize(4 * texels.sites());
    level.now().draw_into();
    gl_.ReadPixels(0, 0, texels.width, texels.height, GL_RGBA, GL_FLOAT, pixels_.data());
    const auto pitch = 4 * static_cast<std::size_t>(texels.width);
    const auto step = 4 / static_cast<std::size_t>(level.texels.columns);
    std::size_t i = 0;
    for (std::size_t row = 0; row < pixels_.size(); row += pitch) {
      for (std::size_t at = row; at < row + step * static_cast<std::size_t>(extent.width); at += step) {
        displacement.x[i] = pixels_[at];
        displacement.y[i] = pixels_[at + 1];
        ++i;
      }
    }
  }

  std::int64_t changed() {
    FragmentLevel& level = levels_.back();
    level.bind_vertices();
    programs_.count(level.texels).use();
    level.now().bind(image_unit);
    level.other().bind(previous_unit);
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, count_framebuffer_.name());
    gl_.BeginQuery(GL_SAMPLES_PASSED, query_.name());
    level.draw_quad(level.header.extent);
    gl_.EndQuery(GL_SAMPLES_PASSED);
    GLuint passed = 0;
    gl_.GetQueryObjectuiv(query_.name(), GL_QUERY_RESULT, &passed);
    return passed;
  }

private:
  void require_fits(Extent extent) const {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    if (extent.width > limit || extent.height > limit) {
      throw TooLarge(fmt::format("the image is {} x {}, this device's rectangle textures end at {} x {}",
                                 extent.width, extent.height, limit, limit));
    }
  }

  /// Levels that are worth it. CPU time of a solution on llvmpipe, 50 sweeps a level: with 256 * 256 the
  /// stiff square of 300 x 300 takes 0.17 s and with this 0.09; circular 0.121 and 0.123, dense 0.117.
  [[nodiscard]] bool leaves_out(const Level& level, Extent extent) const {
    constexpr std::size_t worth_it = std::size_t{128} * 128;
    return leaves_out_ && changes_spread_by_contact(level) && extent.sites() >= worth_it;
  }

  [[nodiscard]] Texels texels_of(const Level& level) const {
    return {.columns = level.rule == Rule::steps && vertex_textures_ ? 2 : 1};
  }

  void add_full_level(const Level& full, Level header) {
    const Texels texels = texels_of(full);
    std::vector<GLfloat> second;
    if (texels.columns == 2) {
      interleave<4>(
          {full.target.x.data(), full.target.y.data(), full.confidence.x.data(), full.confidence.y.data()},
          full.extent.sites(), pixels_);
      interleave_pairs(full.inverse_modulus.values, full.modulus.values, full.extent, second);
    } else {
      interleave<4>({full.target.x.data(), full.target.y.data(), full.modulus.values.data(),
                     full.inverse_modulus.values.data()},
                    full.extent.sites(), pixels_);
      const bool curvature = needs_inverse_curvature(full.rule);
      interleave<4>({full.confidence.x.data(), full.confidence.y.data(),
                     curvature ? full.inverse_curvature.x.data() : nullptr,
                     curvature ? full.inverse_curvature.y.data() : nullptr},
                    full.extent.sites(), second);
    }
    levels_.emplace_back(gl_, std::move(header), full, Alignment::corner, texels, pixels_.data(),
                         second.data(), leaves_out(full, full.extent));
  }

  /// Observations and confidences of the levels from those of the full image, which is the last one.
  void sample_levels() {
    FragmentLevel& full = levels_.back();
    full.bind_vertices();
    for (std::size_t i = 0; i + 1 < levels_.size(); ++i) {
      tables_[i].bind(table_unit);
      const auto draw = [&](const Program& program, const Target& from, Target& into) {
        program.use();
        from.bind(image_unit);
        into.make_drawable();
        full.draw_quad(into.extent());
      };
      Constants& constants = levels_[i].constants;
      draw(programs_.sample(), full.constants.observation, constants.observation);
      draw(programs_.sample(full.texels), full.constants.second, constants.second);
    }
  }

  void project(const Target& before, const Target& table, FragmentLevel& level) {
    programs_.project(level.texels).use();
    before.bind(image_unit);
    level.constants.observation.bind(observation_unit);
    table.bind(table_unit);
    level.now().draw_into();
    level.draw_quad(level.now().extent());
  }

  void sweep(FragmentLevel& level, int first, int sweeps) {
    level.bind_vertices();
    level.constants.second.bind(second_unit);
    if (level.constants.inputs) {
      level.constants.inputs->bind(inputs_unit);
    }
    std::vector<const SweepProgram*> programs;
    for (const FragmentLevel::Draw& draw : level.draws) {
      programs.push_back(&programs_.sweep(level, draw));
    }
    for (int number = first; number < first + sweeps; ++number) {
      if (level.activity) {
        (level.all_awake ? level.activity->everything : level.activity->awake).bind(awake_unit);
      }
      level.now().bind(image_unit);
      level.constants.observation.bind(observation_unit);
      level.other().draw_into();
      level.prepare_tiles(FragmentLevel::tile_side);
      for (std::size_t i = 0; i < programs.size(); ++i) {
        programs[i]->program.use();
        programs[i]->set_turn(gl_, sweep_state(level.header, number));
        level.draw_points(level.draws[i]);
      }
      level.swap();
      if (level.activity && level.activity->is_due()) {
        find_awake(level);
      }
    }
  }

  /// Which tiles the next sweep has to visit. Those that slept have not touched their cells.
  void find_awake(FragmentLevel& level) {
    programs_.cells(level).use();
    level.now().bind(image_unit);
    level.other().bind(previous_unit);
    level.activity->cells.draw_into();
    level.prepare_tiles(FragmentLevel::cells_along_a_tile);
    level.draw_all_tiles(FragmentLevel::cells_along_a_tile);
    programs_.wake().use();
    level.activity->cells.bind(image_unit);
    level.activity->awake.draw_into();
    level.draw_quad(level.grid);
    level.all_awake = false;
  }

  void make_count_target() {
    const Extent extent = levels_.back().header.extent;
    gl_.BindRenderbufferEXT(GL_RENDERBUFFER_EXT, count_target_.name());
    gl_.RenderbufferStorageEXT(GL_RENDERBUFFER_EXT, GL_RGBA8, extent.width, extent.height);
    gl_.BindFramebufferEXT(GL_FRAMEBUFFER_EXT, count_framebuffer_.name());
    gl_.FramebufferRenderbufferEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_RENDERBUFFER_EXT,
                                   count_target_.name());
    require_complete(gl_);
  }

  const Api& gl_;
  std::vector<FragmentLevel> levels_; ///< one, or those of a pyramid
  std::vector<Target> tables_;        ///< per level of a pyramid
  std::vector<int> pyramid_sweeps_;   ///< per level of a pyramid
  Framebuffer count_framebuffer_;
  Renderbuffer count_target_;
  Query query_;
  FragmentPrograms programs_;
  bool vertex_textures_; ///< vertex shaders can fetch: not a device of the thesis's generation
  bool leaves_out_;      ///< what cannot change
  std::vector<float> inverse_modulus_;
  std::vector<GLfloat> pixels_; ///< RGBA staging
};

} // namespace

std::unique_ptr<Backend> make_fragment(std::string_view name, std::string_view description,
                                       std::unique_ptr<Platform> platform) {
  return std::make_unique<ContextBackend<FragmentSweep>>(name, description, std::move(platform), required);
}

} // namespace hdmbench::gl
