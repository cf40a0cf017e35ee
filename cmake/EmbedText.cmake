# sightline_embed_text(NAME FILE)
# For configure_file: NAME_BYTES, the elements of a char array, and NAME_TAG, half of its SHA-256. A program with such a text
# needs no file beside it.
function(sightline_embed_text name file)
  get_filename_component(file ${file} ABSOLUTE)
  if(NOT CMAKE_SCRIPT_MODE_FILE)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endif()
  file(READ ${file} text HEX)
  # Bytes above 127 are no number that fits a char, but a character.
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${text}")
  file(SHA256 ${file} hash)
  string(SUBSTRING ${hash} 0 32 tag)
  set(${name}_BYTES ${bytes} PARENT_SCOPE)
  set(${name}_TAG ${tag} PARENT_SCOPE)
endfunction()
