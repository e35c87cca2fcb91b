@canvas 1040,340
set multiplot layout 1,2
@panel
set title 'noise of the measured velocity, in both loops'
set xlabel 'standard deviation [mrad/s]'
set ylabel 'power of dq in 20-150 Hz, RS : proposed'
set logscale xy
plot $data using (of(1, 0, 2)):(10) @dashed lc rgb REFERENCE title 'the paper''s 10', \
  '' using (of(1, 0, 2)):3 @line lc rgb RS title 'calibrated loops'
@panel
set title 'spread of the states'' arrival, in the synchronous loop'
set xlabel 'standard deviation [us]'
set ylabel 'power of dq in 20-150 Hz, RS : proposed'
set logscale xy
plot $data using (of(1, 1, 2)):(10) @dashed lc rgb REFERENCE title 'the paper''s 10', \
  '' using (of(1, 1, 2)):3 @line lc rgb RS title 'one beat in the motion', \
  '' using (of(1, 2, 2)):3 @line lc rgb RA title 'no beat'
