#include "backends/gl/elastic_compute.hpp"

#include "backends/gl/buffer_texture.hpp"
#include "backends/gl/elastic_context.hpp"

#include <fmt/format.h>
#include <shaders/elastic_coarse_compute.hpp>
#include <shaders/elastic_compute.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>

namespace hdmbench::gl {

namespace {

constexpr GLint parameters_location = 0;

class ElasticCompute {
public:
  static constexpr int block = 8;
  static constexpr bool has_lists = true;
  static constexpr bool has_coarse =
      true; // OpenGL 4.3 guarantees 1024 invocations and 32 KiB of shared memory

  ElasticCompute(const Api& api, bool is_software)
      : gl_(api), is_software_(is_software), kept_(api), moments_(api), more_(api), response_(api),
        matrices_(api), inverse_(api), touched_(api) {
    for (int i = 0; i < elastic_slots + 2; ++i) {
      slots_.emplace_back(api);
    }
  }

  [[nodiscard]] std::int64_t coarse_size() const { return elastic_coarse_size(is_software_); }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) {
    require_fits(layout);
    layout_ = layout;
    const auto size = static_cast<std::size_t>(layout.size);
    const std::vector<GLfloat> zeros(2 * size);
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const std::size_t pairs = i < elastic_slots ? size : static_cast<std::size_t>(layout.sums_size);
      slots_[i].allocate(GL_RG32F, pairs * bytes_of_pair, zeros.data());
    }
    kept_.allocate(GL_RG32F, 3 * ELASTIC_COARSE_SITES * bytes_of_pair, nullptr);
    ElasticTexels texels(size);
    for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
      texels.add(hierarchy.levels[level], layout.levels[level]);
    }
    const auto send = [](const std::vector<float>& values, GLenum format, const BufferTexture& to) {
      to.allocate(format, values.size() * sizeof(GLfloat), values.data());
    };
    send(texels.moments, GL_RGBA32F, moments_);
    send(texels.more, GL_RGBA32F, more_);
    send(texels.response, GL_RGBA32F, response_);
    send(elastic_matrices(hierarchy), GL_RGBA32F, matrices_);
    send(hierarchy.coarsest_inverse, GL_RG32F, inverse_);
    send(ElasticTouched(hierarchy).texels, GL_RG32F, touched_);
  }

  void write(ElasticArray to, const VectorField& values) const {
    const ElasticLayout::Part& part = part_of(to);
    std::vector<GLfloat> pairs(region(part));
    for_each_row(part, [&](int x, std::size_t site, std::size_t row) {
      pairs[row + 2 * static_cast<std::size_t>(x)] = values.x[site];
      pairs[row + 2 * static_cast<std::size_t>(x) + 1] = values.y[site];
    });
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    slot(to).write(pairs, offset(part));
  }

  void read(ElasticArray array, VectorField& values) const {
    const ElasticLayout::Part& part = part_of(array);
    std::vector<GLfloat> pairs(region(part));
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    slot(array).read(pairs, offset(part));
    for_each_row(part, [&](int x, std::size_t site, std::size_t row) {
      values.x[site] = pairs[row + 2 * static_cast<std::size_t>(x)];
      values.y[site] = pairs[row + 2 * static_cast<std::size_t>(x) + 1];
    });
  }

  [[nodiscard]] float read_sum(ElasticArray array) const {
    GLfloat sum = 0.0F;
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    slot(array).read({&sum, 1});
    return sum;
  }

  void run(const ElasticCall& call) {
    compiled(call.kernel).use();
    slot(call.from).bind(ELASTIC_FROM);
    slot(call.second).bind(ELASTIC_SECOND);
    slot(call.to).bind_image(ELASTIC_STORED, GL_RG32F);
    const Extent groups = elastic_groups(call, elastic_shape(is_software_));
    dispatch(call.parameters, groups);
  }

  void run(const ElasticCoarse& coarse) {
    if (!coarse_) {
      coarse_.emplace(gl_,
                      std::initializer_list<Program::Stage>{
                          {GL_COMPUTE_SHADER, assemble(sources::elastic_coarse_compute,
                                                       definitions(elastic_coarse_shape(is_software_)))}});
    }
    coarse_->use();
    for (GLuint i = 0; i < elastic_slots_on_levels; ++i) {
      slots_[i].bind(ELASTIC_FROM + i);
      slots_[i].bind_image(ELASTIC_STORED + i, GL_RG32F);
    }
    kept_.bind_image(ELASTIC_KEPT, GL_RG32F, GL_READ_WRITE);
    dispatch(coarse, {1, 1});
  }

private:
  static constexpr std::size_t bytes_of_pair = 2 * sizeof(GLfloat);

  [[nodiscard]] const ElasticLayout::Part& part_of(ElasticArray array) const {
    return layout_.levels.at(static_cast<std::size_t>(array.level));
  }
  [[nodiscard]] const BufferTexture& slot(ElasticArray array) const {
    return slots_.at(static_cast<std::size_t>(array.slot));
  }
  /// Floats of whole rows.
  [[nodiscard]] static std::size_t region(const ElasticLayout::Part& part) {
    return static_cast<std::size_t>(2 * part.pitch * part.sites.height);
  }
  [[nodiscard]] static std::size_t offset(const ElasticLayout::Part& part) {
    return static_cast<std::size_t>(part.first) * bytes_of_pair;
  }
  /// call(x, site in reading order, float where its row begins in the region) for every site.
  template <typename Call>
  static void for_each_row(const ElasticLayout::Part& part, const Call& call) {
    for (int y = 0; y < part.sites.height; ++y) {
      for (int x = 0; x < part.sites.width; ++x) {
        call(x, part.sites.index(x, y), static_cast<std::size_t>(2 * part.pitch * y));
      }
    }
  }

  [[nodiscard]] std::string definitions(const ElasticShape& shape) const {
    return fmt::format("#define LANES {}\n#define ROWS {}\n#define IN_SHARED {}\n", shape.lanes, shape.rows,
                       elastic_in_shared(is_software_) ? 1 : 0);
  }

  /// The program and the fields are bound; `parameters` consists of words, which is how the program has them.
  template <typename Parameters>
  void dispatch(const Parameters& parameters, Extent groups) const {
    moments_.bind(ELASTIC_MOMENTS);
    more_.bind(ELASTIC_MORE);
    response_.bind(ELASTIC_RESPONSE);
    matrices_.bind(ELASTIC_MATRICES);
    inverse_.bind(ELASTIC_INVERSE);
    touched_.bind(ELASTIC_TOUCHED);
    const auto words = std::bit_cast<std::array<GLint, sizeof(Parameters) / sizeof(GLint)>>(parameters);
    gl_.Uniform1iv(parameters_location, static_cast<GLsizei>(words.size()), words.data());
    gl_.DispatchCompute(static_cast<GLuint>(groups.width), static_cast<GLuint>(groups.height), 1);
    gl_.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  }

  void require_fits(const ElasticLayout& layout) const {
    GLint texels = 0;
    gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    constexpr int largest_height = 65535; // groups along y
    const Extent sites = layout.levels.front().sites;
    if (layout.size > texels || sites.height > largest_height) {
      throw TooLarge(fmt::format("{} x {} sites need {} texels in a buffer for the elastic energy, this "
                                 "device's buffer textures end at {} texels and {} rows",
                                 sites.width, sites.height, layout.size, texels, largest_height));
    }
  }

  const Program& compiled(const ElasticKernel& kernel) {
    auto found = programs_.find(kernel);
    if (found == programs_.end()) {
      const std::string text = assemble(
          sources::elastic_compute, elastic_definitions(kernel) + definitions(elastic_shape(is_software_)));
      found =
          programs_.try_emplace(kernel, gl_, std::initializer_list<Program::Stage>{{GL_COMPUTE_SHADER, text}})
              .first;
    }
    return found->second;
  }

  const Api& gl_;
  bool is_software_;
  ElasticLayout layout_;
  std::vector<BufferTexture> slots_;
  BufferTexture kept_; ///< of elastic_coarse.comp
  BufferTexture moments_;
  BufferTexture more_;
  BufferTexture response_;
  BufferTexture matrices_;
  BufferTexture inverse_;
  BufferTexture touched_;
  std::optional<Program> coarse_;
  std::map<ElasticKernel, Program> programs_;
};

} // namespace

std::unique_ptr<ElasticDevice> make_elastic_compute(std::unique_ptr<Context> context, bool is_software) {
  return std::make_unique<ContextElastic<ElasticCompute>>(std::move(context), is_software);
}

} // namespace hdmbench::gl
