# Amplitude of the compliant arm, half of peak to peak, 16 to 21 s after a push of 10 N, by the share of the model's friction that the
# controller adds: measured beforehand, see models/applications/README.md.
$swinging << EOD
share [%],free [mm],dry [mm]
0,0,0
10,0.1,0
20,0.5,0
30,2.4,0
40,12,0
50,34,0
60,53,0
80,87,0
100,121,0
EOD
@canvas 900,300
@panel
set xlabel 'friction compensated [% of the model''s]'
set ylabel 'amplitude [mm]'
plot $swinging using 1:2 @line lc rgb RS title 'joints that run freely (lab a)', \
  '' using 1:3 @line lc rgb RA title 'joints with the model''s friction'
