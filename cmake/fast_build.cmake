# What makes a clean build fast. Compiling is mostly Eigen's templates: reading them and instantiating them, file by
# file. HGG_FAST_BUILD=OFF compiles every file by itself, as it is written: so a file is found that lacks an include which
# the precompiled headers, or a neighbour, would have had. `make lint` takes its flags from such a build.

# Precompile Eigen, the common standard headers and those named after the target.
function(hgg_precompile_headers target)
  if(HGG_FAST_BUILD)
    target_precompile_headers(${target} PRIVATE <Eigen/Dense> <algorithm> <filesystem> <functional> <map> <optional> <set>
                              <string> <unordered_map> <vector> ${ARGN})
  endif()
endfunction()

# Compile up to `count` files of one folder as one: what they include and instantiate is then compiled once. Two such
# files must not define one name in their anonymous namespaces; the compiler says so. Not for src/: there, a change to
# one file should compile that file only.
function(hgg_compile_together target count)
  if(NOT HGG_FAST_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  get_target_property(root ${target} SOURCE_DIR)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH folder)
    file(RELATIVE_PATH folder ${root} ${folder})
    string(MAKE_C_IDENTIFIER "${folder}" folder)
    set(group ${folder}_0)
    if(DEFINED ${folder}_files)
      math(EXPR batch "${${folder}_files} / ${count}")
      set(group ${folder}_${batch})
    else()
      set(${folder}_files 0)
    endif()
    math(EXPR ${folder}_files "${${folder}_files} + 1")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
