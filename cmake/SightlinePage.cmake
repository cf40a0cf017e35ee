# The pages at / and /learn: modules of server/page/app, bundled by esbuild when the server is built.
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

# Adds the rule that makes `output`, a C++ file with the texts of the page.
function(sightline_page output)
  set(app ${CMAKE_CURRENT_SOURCE_DIR}/app)
  set(modules ${CMAKE_BINARY_DIR}/page)
  set(reason "SIGHTLINE_PAGE is OFF")
  if(SIGHTLINE_PAGE)
    set(reason "")
    sightline_install_page_packages(${app} ${modules} reason)
  endif()
  if(reason AND SIGHTLINE_PAGE AND NOT SIGHTLINE_PAGE STREQUAL "AUTO")
    message(FATAL_ERROR "SIGHTLINE_PAGE=${SIGHTLINE_PAGE}, but ${reason}")
  elseif(reason)
    message(STATUS "Page: left out of the binary, ${reason}; / will say how to build it")
    set(html ${CMAKE_CURRENT_SOURCE_DIR}/unbuilt/index.html)
    set(script ${CMAKE_CURRENT_SOURCE_DIR}/unbuilt/page.js)
    set(style ${CMAKE_CURRENT_SOURCE_DIR}/unbuilt/page.css)
    set(learn_html ${html})
    set(learn_script ${script})
  else()
    message(STATUS "Page: bundled into the binary")
    set(html ${app}/index.html)
    set(script ${modules}/page.js)
    set(style ${modules}/page.css)
    set(learn_html ${app}/learn.html)
    set(learn_script ${modules}/learn.js)
    file(GLOB sources CONFIGURE_DEPENDS ${app}/src/*.js ${app}/src/*.css)
    # Without source maps and paths: everybody gets the same bytes.
    add_custom_command(
      OUTPUT ${script} ${style} ${learn_script}
      COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${modules}/node_modules ${NODE_PROGRAM}
              ${modules}/node_modules/esbuild/bin/esbuild src/page.js src/learn.js src/page.css --outdir=${modules} --bundle --minify
              --format=iife --target=es2022 --charset=ascii --legal-comments=eof --log-level=warning
      WORKING_DIRECTORY ${app}
      DEPENDS ${sources} ${modules}/node_modules/.installed
      COMMENT "Bundling the page"
      VERBATIM)
  endif()
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -D HTML=${html} -D SCRIPT=${script} -D STYLE=${style}
            -D LEARN_HTML=${learn_html} -D LEARN_SCRIPT=${learn_script}
            -D TEMPLATE=${CMAKE_CURRENT_SOURCE_DIR}/app_page.cpp.in -D OUTPUT=${output}
            -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
    DEPENDS ${html} ${script} ${style} ${learn_html} ${learn_script} ${CMAKE_CURRENT_SOURCE_DIR}/app_page.cpp.in
            ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake ${PROJECT_SOURCE_DIR}/cmake/EmbedText.cmake
    COMMENT "Embedding the page"
    VERBATIM)
endfunction()
