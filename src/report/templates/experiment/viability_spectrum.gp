@canvas 900,330
@panel
set title 'Joint 1 on the canonical trajectory: 4 us jitter, 50 ppm, 0.41 % lost' @heading
set xlabel 'f [Hz]'
set ylabel 'PSD of dq_d [(rad/s)^2/Hz]'
set logscale xy
plot $data using 1:2 @line lc rgb series(1) title 'rejoining generator, filter', \
  '' using 1:3 @line lc rgb series(2) title 'the paper''s generator'
