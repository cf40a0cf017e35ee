# sightline_embed_text(NAME FILE)
# For configure_file: NAME_BYTES, the elements of a char array (so the file has to be ASCII), and NAME_TAG, half of its
# SHA-256. A program with such a text needs no file beside it.
function(sightline_embed_text name file)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} text HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${text}")
  file(SHA256 ${CMAKE_CURRENT_SOURCE_DIR}/${file} hash)
  string(SUBSTRING ${hash} 0 32 tag)
  set(${name}_BYTES ${bytes} PARENT_SCOPE)
  set(${name}_TAG ${tag} PARENT_SCOPE)
endfunction()
