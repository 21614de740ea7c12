#version 450
// Hands a control point (two vec4) to the control shader.
layout(location = 0) in vec4 point_a;
layout(location = 1) in vec4 point_b;
layout(location = 0) out vec4 control_a;
layout(location = 1) out vec4 control_b;

void main()
{
    control_a = point_a;
    control_b = point_b;
}
