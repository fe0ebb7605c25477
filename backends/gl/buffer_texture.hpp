#pragma once

#include "backends/gl/objects.hpp"

#include <cstddef>
#include <span>

namespace hdmbench::gl {

/// A buffer that shaders read as a texture of one row. The context must be current in all calls.
class BufferTexture {
public:
  explicit BufferTexture(const Api& api) : gl_(&api), buffer_(api), texture_(api) {}

  /// `bytes` of texels of `format`; uninitialised where data is null.
  void allocate(GLenum format, std::size_t bytes, const GLfloat* data) const {
    gl_->BindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    gl_->BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_COPY);
    gl_->BindTexture(GL_TEXTURE_BUFFER, texture_.name());
    gl_->TexBuffer(GL_TEXTURE_BUFFER, format, buffer_.name());
  }
  /// From byte `offset` on.
  void write(std::span<const GLfloat> data, std::size_t offset = 0) const {
    gl_->BindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    gl_->BufferSubData(GL_TEXTURE_BUFFER, static_cast<GLintptr>(offset),
                       static_cast<GLsizeiptr>(data.size_bytes()), data.data());
  }
  void read(std::span<GLfloat> data, std::size_t offset = 0) const {
    gl_->BindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    gl_->GetBufferSubData(GL_TEXTURE_BUFFER, static_cast<GLintptr>(offset),
                          static_cast<GLsizeiptr>(data.size_bytes()), data.data());
  }
  void bind(GLenum unit) const {
    gl_->ActiveTexture(GL_TEXTURE0 + unit);
    gl_->BindTexture(GL_TEXTURE_BUFFER, texture_.name());
  }
  /// As an image, by default one that shaders store to.
  void bind_image(GLuint unit, GLenum format, GLenum access = GL_WRITE_ONLY) const {
    gl_->BindImageTexture(unit, texture_.name(), 0, GL_FALSE, 0, access, format);
  }

private:
  const Api* gl_;
  Buffer buffer_;
  Texture texture_;
};

} // namespace hdmbench::gl
