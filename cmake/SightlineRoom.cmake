# How every target is compiled, and how a room declares itself.

add_library(sightline_flags INTERFACE)
target_include_directories(sightline_flags INTERFACE ${PROJECT_SOURCE_DIR})
# Contraction is off because exact predicates depend on every rounding being the one that is
# written down; both g++ and clang fuse a*b+c as soon as FMA is allowed.
target_compile_options(
  sightline_flags
  INTERFACE -ffp-contract=off
            -Wall
            -Wextra
            -Wpedantic
            -Wconversion
            -Wsign-conversion
            -Wshadow
            -Wnon-virtual-dtor
            -Wold-style-cast
            $<$<BOOL:${SIGHTLINE_WARNINGS_AS_ERRORS}>:-Werror>)
if(SIGHTLINE_SANITIZE)
  target_compile_options(sightline_flags INTERFACE -fsanitize=${SIGHTLINE_SANITIZE}
                                                   -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(sightline_flags INTERFACE -fsanitize=${SIGHTLINE_SANITIZE})
endif()
if(SIGHTLINE_FUZZ)
  target_compile_options(sightline_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Files of a room that share heavy headers are compiled a few at a time: 22 files of one test took 127 s of processor
# time alone and 55 s together (precompiled headers saved a tenth). With 24 at a time instead of 12 the first build takes
# 297 s instead of 336. Off with clang, so that every file is known to include what it needs.
option(SIGHTLINE_TOGETHER "Compile the files of some rooms a few at a time" ON)

function(sightline_compile_together target)
  if(SIGHTLINE_TOGETHER AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 24)
  endif()
endfunction()

# sightline_room(NAME [SOURCES a.cpp ...] [GENERATED b.cpp ...] ROOMS base geometry ... LIBRARIES fmt::fmt ... [TOGETHER])
# A room is a static library of its SOURCES (default: all .cpp files below its folder) and of files that are GENERATED.
# ROOMS are the rooms that it may include; tests/laws compares them with the #include lines.
function(sightline_room name)
  cmake_parse_arguments(ROOM "TOGETHER" "" "SOURCES;GENERATED;ROOMS;LIBRARIES" ${ARGN})
  if(NOT ROOM_SOURCES)
    file(GLOB_RECURSE ROOM_SOURCES RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS *.cpp)
    list(FILTER ROOM_SOURCES EXCLUDE REGEX node_modules/)
  endif()
  add_library(sightline_${name} STATIC ${ROOM_SOURCES} ${ROOM_GENERATED})
  target_link_libraries(sightline_${name} PUBLIC sightline_flags)
  foreach(room IN LISTS ROOM_ROOMS)
    target_link_libraries(sightline_${name} PUBLIC sightline_${room})
  endforeach()
  target_link_libraries(sightline_${name} PUBLIC ${ROOM_LIBRARIES})
  if(ROOM_TOGETHER)
    sightline_compile_together(sightline_${name})
  endif()
endfunction()
