# find_package(hgg_lcmtypes): the target hgg::lcmtypes, headers of hggmap's messages with LCM behind them.
find_package(PkgConfig REQUIRED)
pkg_check_modules(HGG_LCM REQUIRED IMPORTED_TARGET lcm)
if(NOT TARGET hgg::lcmtypes)
  # From PREFIX/LIBDIR/cmake/hgg_lcmtypes, where LIBDIR may be lib or lib/x86_64-linux-gnu.
  find_path(HGG_LCMTYPES_INCLUDE_DIR hgg/goal_query_t.hpp HINTS ${CMAKE_CURRENT_LIST_DIR}/../../../include/hgg_lcmtypes
            ${CMAKE_CURRENT_LIST_DIR}/../../../../include/hgg_lcmtypes REQUIRED)
  add_library(hgg::lcmtypes INTERFACE IMPORTED)
  target_include_directories(hgg::lcmtypes INTERFACE ${HGG_LCMTYPES_INCLUDE_DIR})
  target_link_libraries(hgg::lcmtypes INTERFACE PkgConfig::HGG_LCM)
endif()
