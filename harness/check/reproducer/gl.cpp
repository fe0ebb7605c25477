// Does the step of step.inc again by OpenGL. Exit status: 0 as expected, 1 other bits, 2 it could not be
// done.
//   g++ -std=c++20 reproduce.cpp -o reproduce -lEGL -lGL && ./reproduce [PART OF ANOTHER DEVICE'S NAME]

#define EGL_NO_X11
#define GL_GLEXT_PROTOTYPES
#include "replay.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>

/// Makes a context current on the first device that has this in its name.
void open_device(const std::string& name) {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto display_of =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  EGLDeviceEXT devices[16];
  EGLint count = 0;
  query(16, devices, &count);
  for (EGLint i = 0; i < count; ++i) {
    const EGLDisplay display = display_of(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                             EGL_NONE};
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
    EGLConfig config;
    EGLint configs = 0;
    if (!eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API) ||
        !eglChooseConfig(display, wanted, &config, 1, &configs) || configs == 0 ||
        !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                        eglCreateContext(display, config, EGL_NO_CONTEXT, version))) {
      continue;
    }
    const std::string found = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    if (found.find(name) != std::string::npos) {
      std::printf("%s, %s\n", found.c_str(), reinterpret_cast<const char*>(glGetString(GL_VERSION)));
      return;
    }
  }
  throw std::runtime_error("no EGL device with OpenGL 4.3 is called " + name);
}

GLuint linked(const Program& text) {
  const std::string bytes = bytes_of(text.file);
  const char* const start = bytes.c_str();
  const GLuint program = glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &start);
  GLint is_linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &is_linked);
  char log[4096] = "";
  glGetProgramInfoLog(program, sizeof log, nullptr, log);
  return is_linked != 0 ? program : throw std::runtime_error(log);
}

int main(int count, char** arguments) try {
  open_device(count > 1 ? arguments[1] : device_name);
  std::vector<GLuint> buffers(arrays.size()), textures(arrays.size()), linked_programs;
  glGenBuffers(static_cast<GLsizei>(arrays.size()), buffers.data());
  glGenTextures(static_cast<GLsizei>(arrays.size()), textures.data());
  const auto format = [&](std::size_t i) { return arrays[i].kind == pairs ? GL_RG32F : GL_RGBA32F; };
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const std::string before = bytes_of(arrays[i].before);
    glBindBuffer(GL_COPY_WRITE_BUFFER, buffers[i]);
    glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(before.size()), before.data(),
                 GL_DYNAMIC_COPY);
    if (arrays[i].kind != words) {
      glBindTexture(GL_TEXTURE_BUFFER, textures[i]);
      glTexBuffer(GL_TEXTURE_BUFFER, format(i), buffers[i]);
    }
  }
  for (const Program& program : programs) {
    linked_programs.push_back(linked(program));
  }
  for (const Command& command : commands) {
    if (command.waits) {
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    }
    if (command.program < 0) {
      const std::string bytes = bytes_of(command.written);
      glBindBuffer(GL_COPY_WRITE_BUFFER, buffers[command.arrays[0].array]);
      glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(command.first),
                      static_cast<GLsizeiptr>(bytes.size()), bytes.data());
      continue;
    }
    glUseProgram(linked_programs[command.program]);
    glUniform1iv(0, static_cast<GLsizei>(command.told.size()), command.told.data());
    if (command.step_count > 0) {
      glUniform1fv(32, static_cast<GLsizei>(command.step_count), command.steps.data());
    }
    for (const auto [binding, array] : command.arrays) {
      if (binding < 4) { // images, storage buffers, textures: by their binding
        glBindImageTexture(binding, textures[array], 0, GL_FALSE, 0, GL_READ_WRITE, format(array));
      } else if (binding < 7) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffers[array]);
      } else {
        glActiveTexture(GL_TEXTURE0 + binding);
        glBindTexture(GL_TEXTURE_BUFFER, textures[array]);
      }
    }
    glDispatchCompute(command.groups[0], command.groups[1], command.groups[2]);
  }
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    throw std::runtime_error("OpenGL's error " + std::to_string(error));
  }
  return compared([&](int array, std::size_t first, std::size_t bytes) {
    std::string made(bytes, '\0');
    glBindBuffer(GL_COPY_READ_BUFFER, buffers[array]);
    glGetBufferSubData(GL_COPY_READ_BUFFER, static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes),
                       made.data());
    return made;
  });
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
