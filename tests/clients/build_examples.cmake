# Installs the client as a user would, and builds its examples against what was installed: cmake -D... -P build_examples.cmake
#   BUILD     the build folder of Isostrata
#   EXAMPLES  where the examples' sources are
#   TO        where it all goes; emptied first
file(REMOVE_RECURSE ${TO})
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "ended with status ${status}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --component client --prefix ${TO}/prefix)
# Nothing of the build may be needed: that the package names no path of it is looked at, too.
file(GLOB configs ${TO}/prefix/lib*/cmake/isostrata/*.cmake ${TO}/prefix/lib/*/cmake/isostrata/*.cmake)
list(LENGTH configs count)
if(count LESS 6)
  message(FATAL_ERROR "the package has ${count} files of CMake; expected 6")
endif()
foreach(config ${configs})
  file(READ ${config} text)
  string(FIND "${text}" "${SOURCE}" place)
  if(NOT place EQUAL -1)
    message(FATAL_ERROR "${config} names the folder it was built from")
  endif()
endforeach()
run(${CMAKE_COMMAND} -S ${EXAMPLES} -B ${TO}/build -G Ninja -DCMAKE_PREFIX_PATH=${TO}/prefix -DCMAKE_BUILD_TYPE=Debug
  "-DCMAKE_CXX_FLAGS_DEBUG=-Wall -Wextra -Werror" -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
run(${CMAKE_COMMAND} --build ${TO}/build)
# Without libvpx the package is found as well, and only isostrata::video is not there.
execute_process(COMMAND pkg-config --variable=pcfiledir libturbojpeg OUTPUT_VARIABLE known OUTPUT_STRIP_TRAILING_WHITESPACE)
file(COPY ${known}/libturbojpeg.pc DESTINATION ${TO}/pkgconfig)
run(${CMAKE_COMMAND} -E env PKG_CONFIG_LIBDIR=${TO}/pkgconfig ${CMAKE_COMMAND} -S ${EXAMPLES} -B ${TO}/without -G Ninja
  -DCMAKE_PREFIX_PATH=${TO}/prefix)
file(READ ${TO}/without/build.ninja plan)
if(plan MATCHES "11_video" OR NOT plan MATCHES "10_save")
  message(FATAL_ERROR "without libvpx the examples are not those that need none")
endif()
