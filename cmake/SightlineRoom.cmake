# How every target of the house is compiled, and how a room declares itself.

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

# sightline_room(NAME SOURCES a.cpp ... ROOMS base geometry ... LIBRARIES fmt::fmt ...)
# A room is a static library. ROOMS are the rooms that it may include; tests/laws holds the same
# table against the #include lines.
function(sightline_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;ROOMS;LIBRARIES" ${ARGN})
  add_library(sightline_${name} STATIC ${ROOM_SOURCES})
  target_link_libraries(sightline_${name} PUBLIC sightline_flags)
  foreach(room IN LISTS ROOM_ROOMS)
    target_link_libraries(sightline_${name} PUBLIC sightline_${room})
  endforeach()
  target_link_libraries(sightline_${name} PUBLIC ${ROOM_LIBRARIES})
endfunction()
