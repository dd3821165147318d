// Debian 12's VTK 9.1 knows one kind of window, X11's, and finds OpenGL's functions through Debian's GLEW, which is built for
// GLX. vtkGenericOpenGLRenderWindow draws in whatever context is current, but refuses to begin where glewInit() fails; and on a
// context without an X display glewInit() first finds all of OpenGL's functions and then fails, since it finds no GLX. (GLVND
// gives the same functions for EGL and GLX.) A definition in the program goes before the library's: this one does what
// the library's does and takes that one failure for what it is. So neither an X server nor a VTK of our own is needed.
#include <dlfcn.h>

extern "C" unsigned glewInit() {
  constexpr unsigned kOk = 0, kNoVersion = 1, kNoGlxDisplay = 4;  // GL/glew.h
  using Function = unsigned (*)();
  const auto found = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "glewInit"));
  if (!found) return kNoVersion;
  const unsigned result = found();
  return result == kNoGlxDisplay ? kOk : result;
}
