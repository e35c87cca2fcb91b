# gain of the low-pass; lambda of the reference generator
s(f) = {0,1}*2*pi*f
response(f) = abs(gain*(s(f) + lambda/1e-3)/(s(f) + gain*lambda/1e-3))
@canvas 900,360
set multiplot layout 1,1 title 'Velocity of the robot''s reference over that of the deposited one' @heading
@panel
set title 'ideal plant, calibrated asynchronous loop, low-pass of 100 Hz'
set xlabel 'f [Hz]'
set ylabel 'share of the velocity'
set logscale x
set xrange [0.01:10]
set yrange [0:1.1]
set samples 200
plot response(x) @line lc rgb REFERENCE title sprintf('g(s + l/T)/(s + g l/T), g = %.3f', gain), \
  $data using 1:2 @points lc rgb RS title 'measured'
