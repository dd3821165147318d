// The OpenGL 4.5 entry points that this room calls, one table per context. libepoxy is not used for them: it resolves through the
// current EGL or GLX context and ends the process under OSMesa, and its pointers are one set per process while two drivers may be
// loaded here.
#pragma once

#include <GL/glcorearb.h>

#define ISOSTRATA_GL_FUNCTIONS(X)                                      \
  X(PFNGLATTACHSHADERPROC, AttachShader)                               \
  X(PFNGLBEGINQUERYPROC, BeginQuery)                                   \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                                   \
  X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                           \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                         \
  X(PFNGLBINDTEXTUREUNITPROC, BindTextureUnit)                         \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                         \
  X(PFNGLBLENDEQUATIONIPROC, BlendEquationi)                           \
  X(PFNGLBLENDFUNCIPROC, BlendFunci)                                   \
  X(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, CheckNamedFramebufferStatus) \
  X(PFNGLCLEARNAMEDBUFFERSUBDATAPROC, ClearNamedBufferSubData)         \
  X(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, ClearNamedFramebufferfv)         \
  X(PFNGLCLIENTWAITSYNCPROC, ClientWaitSync)                           \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                             \
  X(PFNGLCREATEBUFFERSPROC, CreateBuffers)                             \
  X(PFNGLCREATEFRAMEBUFFERSPROC, CreateFramebuffers)                   \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                             \
  X(PFNGLCREATEQUERIESPROC, CreateQueries)                             \
  X(PFNGLCREATESHADERPROC, CreateShader)                               \
  X(PFNGLCREATETEXTURESPROC, CreateTextures)                           \
  X(PFNGLCREATEVERTEXARRAYSPROC, CreateVertexArrays)                   \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                             \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                   \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                             \
  X(PFNGLDELETEQUERIESPROC, DeleteQueries)                             \
  X(PFNGLDELETESHADERPROC, DeleteShader)                               \
  X(PFNGLDELETESYNCPROC, DeleteSync)                                   \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures)                           \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                   \
  X(PFNGLDISABLEPROC, Disable)                                         \
  X(PFNGLDISABLEVERTEXARRAYATTRIBPROC, DisableVertexArrayAttrib)       \
  X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                         \
  X(PFNGLDISPATCHCOMPUTEINDIRECTPROC, DispatchComputeIndirect)         \
  X(PFNGLDRAWARRAYSPROC, DrawArrays)                                   \
  X(PFNGLENABLEPROC, Enable)                                           \
  X(PFNGLENABLEVERTEXARRAYATTRIBPROC, EnableVertexArrayAttrib)         \
  X(PFNGLENDQUERYPROC, EndQuery)                                       \
  X(PFNGLFENCESYNCPROC, FenceSync)                                     \
  X(PFNGLFINISHPROC, Finish)                                           \
  X(PFNGLFLUSHPROC, Flush)                                             \
  X(PFNGLGETERRORPROC, GetError)                                       \
  X(PFNGLGETINTEGER64VPROC, GetInteger64v)                             \
  X(PFNGLGETINTEGERI_VPROC, GetIntegeri_v)                             \
  X(PFNGLGETINTEGERVPROC, GetIntegerv)                                 \
  X(PFNGLGETNAMEDBUFFERSUBDATAPROC, GetNamedBufferSubData)             \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                     \
  X(PFNGLGETPROGRAMRESOURCEINDEXPROC, GetProgramResourceIndex)         \
  X(PFNGLGETPROGRAMRESOURCEIVPROC, GetProgramResourceiv)               \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                               \
  X(PFNGLGETQUERYOBJECTUI64VPROC, GetQueryObjectui64v)                 \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                       \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                                 \
  X(PFNGLGETSTRINGPROC, GetString)                                     \
  X(PFNGLGETSTRINGIPROC, GetStringi)                                   \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                                 \
  X(PFNGLMAPNAMEDBUFFERRANGEPROC, MapNamedBufferRange)                 \
  X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                             \
  X(PFNGLMULTIDRAWARRAYSINDIRECTPROC, MultiDrawArraysIndirect)         \
  X(PFNGLNAMEDBUFFERSTORAGEPROC, NamedBufferStorage)                   \
  X(PFNGLNAMEDBUFFERSUBDATAPROC, NamedBufferSubData)                   \
  X(PFNGLNAMEDFRAMEBUFFERDRAWBUFFERSPROC, NamedFramebufferDrawBuffers) \
  X(PFNGLNAMEDFRAMEBUFFERREADBUFFERPROC, NamedFramebufferReadBuffer)   \
  X(PFNGLNAMEDFRAMEBUFFERTEXTUREPROC, NamedFramebufferTexture)         \
  X(PFNGLPIXELSTOREIPROC, PixelStorei)                                 \
  X(PFNGLPROGRAMUNIFORM1UIPROC, ProgramUniform1ui)                     \
  X(PFNGLPROGRAMUNIFORM2FPROC, ProgramUniform2f)                       \
  X(PFNGLPROGRAMUNIFORM4FPROC, ProgramUniform4f)                       \
  X(PFNGLPROGRAMUNIFORM4UIPROC, ProgramUniform4ui)                     \
  X(PFNGLQUERYCOUNTERPROC, QueryCounter)                               \
  X(PFNGLREADPIXELSPROC, ReadPixels)                                   \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                               \
  X(PFNGLTEXTUREBUFFERPROC, TextureBuffer)                             \
  X(PFNGLTEXTUREPARAMETERIPROC, TextureParameteri)                     \
  X(PFNGLTEXTURESTORAGE2DPROC, TextureStorage2D)                       \
  X(PFNGLTEXTURESTORAGE3DPROC, TextureStorage3D)                       \
  X(PFNGLTEXTURESUBIMAGE2DPROC, TextureSubImage2D)                     \
  X(PFNGLTEXTURESUBIMAGE3DPROC, TextureSubImage3D)                     \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                                   \
  X(PFNGLVERTEXARRAYATTRIBBINDINGPROC, VertexArrayAttribBinding)       \
  X(PFNGLVERTEXARRAYATTRIBFORMATPROC, VertexArrayAttribFormat)         \
  X(PFNGLVERTEXARRAYATTRIBIFORMATPROC, VertexArrayAttribIFormat)       \
  X(PFNGLVERTEXARRAYVERTEXBUFFERPROC, VertexArrayVertexBuffer)         \
  X(PFNGLVIEWPORTPROC, Viewport)

namespace isostrata {

struct GlFunctions {
#define ISOSTRATA_GL_MEMBER(type, name) type name = nullptr;
  ISOSTRATA_GL_FUNCTIONS(ISOSTRATA_GL_MEMBER)
#undef ISOSTRATA_GL_MEMBER
  // Optional: null if the driver has none.
  PFNGLGETGRAPHICSRESETSTATUSPROC GetGraphicsResetStatus = nullptr;
  void(APIENTRYP GetUnsignedBytei_vEXT)(GLenum target, GLuint index, GLubyte* data) = nullptr;
};

}  // namespace isostrata
