# axiscal_proto_library(name ROOT dir PROTOS a.proto ... [IMPORTS dir ...] [DEPS lib ...] [GRPC]): C++ from .proto files, as library axiscal_<name>.
# Messages (and with GRPC the service stubs) are generated below ${CMAKE_BINARY_DIR}/generated and included as "axiscal/v1/job.pb.h".
find_program(AXISCAL_GRPC_PLUGIN grpc_cpp_plugin REQUIRED)

set(AXISCAL_GENERATED_DIR ${CMAKE_BINARY_DIR}/generated)

function(axiscal_proto_library name)
  cmake_parse_arguments(ARG "GRPC" "ROOT" "PROTOS;IMPORTS;DEPS" ${ARGN})
  set(flags -I ${ARG_ROOT})
  foreach(dir ${ARG_IMPORTS})
    list(APPEND flags -I ${dir})
  endforeach()
  set(pch <google/protobuf/message.h> <google/protobuf/generated_message_reflection.h> <google/protobuf/reflection_ops.h>
          <google/protobuf/repeated_field.h> <google/protobuf/io/coded_stream.h> <google/protobuf/wire_format.h>)
  if(ARG_GRPC)
    # Requests are looked through before they are read.
    list(APPEND flags --grpc_out=additional_header_includes=proto/guard/message_guard.h:${AXISCAL_GENERATED_DIR} --plugin=protoc-gen-grpc=${AXISCAL_GRPC_PLUGIN})
    list(APPEND pch <grpcpp/grpcpp.h>)
  endif()
  set(sources)
  set(messages)
  foreach(proto ${ARG_PROTOS})
    string(REPLACE ".proto" "" stem ${proto})
    set(outputs ${AXISCAL_GENERATED_DIR}/${stem}.pb.cc ${AXISCAL_GENERATED_DIR}/${stem}.pb.h)
    if(ARG_GRPC)
      list(APPEND outputs ${AXISCAL_GENERATED_DIR}/${stem}.grpc.pb.cc ${AXISCAL_GENERATED_DIR}/${stem}.grpc.pb.h)
    endif()
    add_custom_command(OUTPUT ${outputs} DEPENDS ${ARG_ROOT}/${proto} VERBATIM
      COMMAND ${CMAKE_COMMAND} -E make_directory ${AXISCAL_GENERATED_DIR}
      COMMAND protobuf::protoc ${flags} --cpp_out=${AXISCAL_GENERATED_DIR} ${ARG_ROOT}/${proto})
    list(APPEND sources ${outputs})
    list(APPEND messages ${AXISCAL_GENERATED_DIR}/${stem}.pb.cc)
  endforeach()
  add_library(axiscal_${name} STATIC ${sources})
  # Stubs of services are compiled in one go (see AXISCAL_UNITY); names that protoc gives messages clash from file to file.
  if(AXISCAL_UNITY AND ARG_GRPC)
    set_target_properties(axiscal_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    set_source_files_properties(${messages} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
  # Generated headers come as system headers: their warnings are not ours.
  target_include_directories(axiscal_${name} SYSTEM PUBLIC ${AXISCAL_GENERATED_DIR})
  target_link_libraries(axiscal_${name} PUBLIC protobuf::libprotobuf ${ARG_DEPS})
  target_compile_options(axiscal_${name} PRIVATE -w)
  target_precompile_headers(axiscal_${name} PRIVATE ${pch})
  if(ARG_GRPC)
    target_link_libraries(axiscal_${name} PUBLIC axiscal_message_guard gRPC::grpc++)
  endif()
endfunction()
