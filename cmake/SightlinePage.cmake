# The pages: modules of server/page/app, bundled by esbuild when the server is built, and the documents of the repository.
#
# SIGHTLINE_PAGE  AUTO  bundle it where node, npm and the packages of its lock file are there
#                 ON    fail at configuration where they are not
#                 OFF   never; / then says how to build it
set(SIGHTLINE_PAGE AUTO CACHE STRING "Bundle the page at /: AUTO, ON or OFF")
set_property(CACHE SIGHTLINE_PAGE PROPERTY STRINGS AUTO ON OFF)

# Sets `reason` where the packages cannot be had. They are installed once for each lock file, below the build tree.
function(sightline_install_page_packages app modules reason)
  find_program(NODE_PROGRAM node)
  find_program(NPM_PROGRAM npm)
  if(NOT NODE_PROGRAM OR NOT NPM_PROGRAM)
    set(${reason} "node or npm is not installed" PARENT_SCOPE)
    return()
  endif()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${app}/package.json ${app}/package-lock.json)
  # The tests drive a browser with one more package.
  set(groups --omit=dev)
  if(SIGHTLINE_TESTS)
    set(groups --include=dev)
  endif()
  file(SHA256 ${app}/package-lock.json wanted)
  string(APPEND wanted " ${groups}")
  set(stamp ${modules}/node_modules/.installed)
  set(installed "")
  if(EXISTS ${stamp})
    file(READ ${stamp} installed)
  endif()
  if(installed STREQUAL wanted)
    return()
  endif()
  message(STATUS "Page: npm ci (${modules})")
  file(COPY ${app}/package.json ${app}/package-lock.json DESTINATION ${modules})
  execute_process(
    COMMAND ${NPM_PROGRAM} ci ${groups} --ignore-scripts --no-audit --no-fund --no-update-notifier --fetch-retries=1
    WORKING_DIRECTORY ${modules} TIMEOUT 300
    RESULT_VARIABLE failed OUTPUT_QUIET ERROR_FILE ${modules}/npm.log)
  if(failed)
    set(${reason} "npm ci failed, see ${modules}/npm.log" PARENT_SCOPE)
    return()
  endif()
  file(WRITE ${stamp} "${wanted}")
endfunction()

# Adds the rule that makes `output`, a C++ file with the texts of the pages.
function(sightline_page output)
  set(app ${CMAKE_CURRENT_SOURCE_DIR}/app)
  set(modules ${CMAKE_BINARY_DIR}/page)
  set(shells index.html learn.html status.html guide.html guide_below.html)
  set(scripts boot.js page.js learn.js status.js guide.js)
  set(reason "SIGHTLINE_PAGE is OFF")
  if(SIGHTLINE_PAGE)
    set(reason "")
    sightline_install_page_packages(${app} ${modules} reason)
  endif()
  set(parts "")
  set(files "")
  file(GLOB documents CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/ARCHITECTURE.md
       ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/docs/*.md ${PROJECT_SOURCE_DIR}/docs/*/*.md)
  if(reason AND SIGHTLINE_PAGE AND NOT SIGHTLINE_PAGE STREQUAL "AUTO")
    message(FATAL_ERROR "SIGHTLINE_PAGE=${SIGHTLINE_PAGE}, but ${reason}")
  elseif(reason)
    message(STATUS "Page: left out of the binary, ${reason}; / will say how to build it")
    set(unbuilt ${CMAKE_CURRENT_SOURCE_DIR}/unbuilt)
    foreach(name IN LISTS shells)
      list(APPEND parts "${name}=${unbuilt}/index.html")
    endforeach()
    foreach(name IN LISTS scripts)
      list(APPEND parts "${name}=${unbuilt}/page.js")
    endforeach()
    list(APPEND parts "page.css=${unbuilt}/page.css" "documents.json.gz=${unbuilt}/page.js")
    set(files ${unbuilt}/index.html ${unbuilt}/page.js ${unbuilt}/page.css)
  else()
    message(STATUS "Page: bundled into the binary")
    file(GLOB sources CONFIGURE_DEPENDS ${app}/src/*.js ${app}/src/*.css)
    list(TRANSFORM scripts PREPEND src/ OUTPUT_VARIABLE inputs)
    list(TRANSFORM scripts PREPEND ${modules}/ OUTPUT_VARIABLE bundles)
    # Without source maps and paths: everybody gets the same bytes.
    add_custom_command(
      OUTPUT ${bundles} ${modules}/page.css
      COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${modules}/node_modules ${NODE_PROGRAM}
              ${modules}/node_modules/esbuild/bin/esbuild ${inputs} src/page.css --outdir=${modules} --bundle --minify
              --format=iife --target=es2022 --charset=ascii --legal-comments=eof --log-level=warning
      WORKING_DIRECTORY ${app}
      DEPENDS ${sources} ${modules}/node_modules/.installed
      COMMENT "Bundling the page"
      VERBATIM)
    set(document_files ${documents})
    list(TRANSFORM document_files PREPEND ${PROJECT_SOURCE_DIR}/)
    add_custom_command(
      OUTPUT ${modules}/documents.json.gz
      COMMAND ${NODE_PROGRAM} ${app}/documents.mjs ${PROJECT_SOURCE_DIR} ${modules}/documents.json.gz ${documents}
      DEPENDS ${document_files} ${app}/documents.mjs
      COMMENT "Packing the documents"
      VERBATIM)
    list(TRANSFORM shells PREPEND ${modules}/ OUTPUT_VARIABLE shell_files)
    add_custom_command(
      OUTPUT ${shell_files}
      COMMAND ${NODE_PROGRAM} ${app}/shells.mjs ${modules}
      DEPENDS ${app}/shells.mjs ${app}/head.html ${app}/index.html ${app}/learn.html ${app}/status.html ${app}/guide.html
      COMMENT "Writing the shells of the pages"
      VERBATIM)
    foreach(name IN LISTS shells scripts ITEMS page.css documents.json.gz)
      list(APPEND parts "${name}=${modules}/${name}")
      list(APPEND files ${modules}/${name})
    endforeach()
  endif()
  # As the routes name them; without the pages each address says how to build them.
  list(TRANSFORM documents REPLACE "^docs/" "")
  list(JOIN parts "|" parts)
  list(JOIN documents "|" documents)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -D "PARTS=${parts}" -D "DOCUMENTS=${documents}"
            -D TEMPLATE=${CMAKE_CURRENT_SOURCE_DIR}/app_page.cpp.in -D OUTPUT=${output}
            -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
    DEPENDS ${files} ${CMAKE_CURRENT_SOURCE_DIR}/app_page.cpp.in
            ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake ${PROJECT_SOURCE_DIR}/cmake/EmbedText.cmake
    COMMENT "Embedding the page"
    VERBATIM)
endfunction()
