# find_package(clearway) gives clearway::clearway (shared) and clearway::static.
get_filename_component(_clearway_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
find_package(Threads REQUIRED)
if(NOT TARGET clearway::clearway)
    add_library(clearway::clearway SHARED IMPORTED)
    set_target_properties(clearway::clearway PROPERTIES
        IMPORTED_LOCATION "${_clearway_prefix}/lib/libclearway.so"
        IMPORTED_NO_SONAME TRUE
        INTERFACE_INCLUDE_DIRECTORIES "${_clearway_prefix}/include")
    add_library(clearway::static STATIC IMPORTED)
    set_target_properties(clearway::static PROPERTIES
        IMPORTED_LOCATION "${_clearway_prefix}/lib/libclearway.a"
        INTERFACE_INCLUDE_DIRECTORIES "${_clearway_prefix}/include"
        INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m;rt")
endif()
set(clearway_FOUND TRUE)
unset(_clearway_prefix)
