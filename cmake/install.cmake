# What others build against: `cmake --install build [--component lcmtypes] [--prefix P]`.
include(GNUInstallDirs)
install(TARGETS hggmap RUNTIME COMPONENT hggmap)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/firmware_cfg DESTINATION ${CMAKE_INSTALL_DATADIR}/hggmap COMPONENT hggmap)

# The message types, as .lcm files for lcm-gen and as C++ headers with a CMake package (examples/cpp).
install(FILES ${LCM_FILES} DESTINATION ${CMAKE_INSTALL_DATADIR}/hggmap/lcmtypes COMPONENT lcmtypes)
install(DIRECTORY ${LCM_OUT}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hgg_lcmtypes COMPONENT lcmtypes
        FILES_MATCHING PATTERN "*.hpp")
install(FILES ${PROJECT_SOURCE_DIR}/cmake/hgg_lcmtypes-config.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/hgg_lcmtypes COMPONENT lcmtypes)
